"""Many flat pieces at once: leaves, wires, the narrow sides of a plate."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh


def facets(corners: ArrayLike, material: Material) -> Mesh:
    """Flat convex pieces with k corners each, of plain colour.

    Args:
        corners: Corners, counter-clockwise seen from outside, shape (n, k, 3), metres.
        material: Material of all; its texture is not laid out (uv is 0).
    """
    points = np.asarray(corners, float)
    count, size = points.shape[:2]
    normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    fan = np.array([(0, i, i + 1) for i in range(1, size - 1)], np.int32)
    first = size * np.arange(count, dtype=np.int32)
    faces = (first[:, None, None] + fan).reshape(-1, 3)
    return Mesh(
        points.reshape(-1, 3).astype(np.float32),
        np.repeat(normals, size, axis=0).astype(np.float32),
        np.zeros((count * size, 2), np.float32),
        faces,
        np.zeros(len(faces), np.int32),
        (material,),
    )
