"""What the kernels need of a scene."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.mesh import Float32s, Int32s
from avsec_gym.world.rendering.ray_scene import MaterialTable
from avsec_gym.world.rendering.texturing import OverlayArrays
from avsec_gym.world.textures.library import TextureArrays


class SceneArrays(NamedTuple):
    """What the kernels need of a scene."""

    vertices: Float32s
    normals: Float32s
    uv: Float32s
    overlay_uv: Float32s
    faces: Int32s
    material: Int32s
    object_id: Int32s
    materials: MaterialTable
    textures: TextureArrays
    overlay: OverlayArrays
    lattice: Float32s
    """Random numbers in [-1, 1], shape (64, 64, 16): breaks up repeating textures."""


def break_up_lattice(seed: int) -> NDArray[np.float32]:
    """The lattice of `SceneArrays`."""
    rng = np.random.Generator(np.random.PCG64(seed))
    return rng.uniform(-1.0, 1.0, (64, 64, 16)).astype(np.float32)
