"""Where laser pulses end in a scene, and how much of their light comes back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.mesh import Float32s, Int32s
from avsec_gym.world.rendering.laser import laser_reflectance
from avsec_gym.world.rendering.moving_bodies import Rays, SweptScene
from avsec_gym.world.rendering.ray_scene import NOTHING
from avsec_gym.world.rendering.renderer import Renderer
from avsec_gym.world.section import Surface

PULSE_ANGLE = 0.003
"""Width of a laser pulse, radians."""


class Echoes(NamedTuple):
    """What n laser pulses met."""

    distance: Float32s
    """Metres, infinite for none, shape (n,)."""
    reflectance: Float32s
    """Reflectance in the infrared, [0, 1], shape (n,)."""
    cosine: Float32s
    """Cosine of the angle of incidence, shape (n,)."""
    mirror: Float32s
    """Share of the light that the surface mirrors, shape (n,)."""
    surface: NDArray[np.uint8]
    """`Surface`, shape (n,)."""
    object_id: Int32s
    """Shape (n,)."""


def laser_echoes(renderer: Renderer, swept: SweptScene, rays: Rays) -> Echoes:
    """Where laser pulses end; they pass one pane of glass without an echo.

    Args:
        renderer: Renderer of the scene.
        swept: The same scene with what moves in it.
        rays: The pulses.
    """
    scene, materials = renderer.scene, renderer.scene.materials
    # The first surface of each pulse, or what is behind it if that is glass.
    face, distance = swept.hits(rays)
    glass = np.flatnonzero((face >= 0) & materials.glass[scene.material[face]])
    if len(glass):
        passed = distance[glass] + np.float32(0.01)
        starts = rays.origins[glass] + passed[:, None] * rays.directions[glass]
        behind, beyond = swept.hits(
            Rays(np.ascontiguousarray(starts), rays.directions[glass], rays.seconds[glass]),
            layers=0,
        )
        again = behind >= 0
        again &= ~materials.glass[scene.material[np.maximum(behind, 0)]]
        face[glass] = np.where(again, behind, -1)
        distance[glass] = np.where(again, beyond + passed, np.inf)
    # What comes back, on triangles at rest.
    seen = face >= 0
    reflectance, cosine = np.zeros_like(distance), np.zeros_like(distance)
    origins, directions = swept.at_rest(face, rays)
    laser_reflectance(renderer.arrays, face, distance, origins, directions, reflectance, cosine)
    met = np.maximum(face, 0)
    return Echoes(
        distance,
        reflectance,
        cosine,
        np.where(seen, materials.mirror[scene.material[met]], np.float32(0.0)),
        np.where(seen, scene.surface[met], Surface.SKY).astype(np.uint8),
        np.where(seen, scene.object_id[met], NOTHING),
    )
