"""Grass along edges: tufts that break the line between a lawn and what lies beside it."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import ArrayLike

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh

BLADES = 3
"""Triangles of a tuft."""

_GRASS = Material("grass_blades", (1.1, 1.1, 1.05), translucent=0.35, infrared=0.55)
_DARKER = Material("grass_blades", (0.8, 0.82, 0.75), translucent=0.35, infrared=0.55)
_TEXTURE = (0.64, 0.25)


def grass_tufts(
    area: ArrayLike, density: float, rng: np.random.Generator, *, height: float = 0.14
) -> Mesh:
    """Tufts of a few blades each, scattered over an area of the ground at z = 0.

    Args:
        area: Corners of a simple polygon, shape (n, 2), metres.
        density: Tufts on a square metre; 25 for a verge beside the camera, with 3 triangles
            each.
        rng: The source of chance.
        height: Height of the longest blades, metres.
    """
    region = shapely.Polygon(np.asarray(area, float))
    shapely.prepare(region)
    left, lower, right, upper = region.bounds
    count = round(density * (right - left) * (upper - lower))
    root = rng.uniform((left, lower), (right, upper), (count, 2))
    root = root[shapely.contains_xy(region, root)]
    tufts = len(root)
    azimuth = rng.uniform(0, 2 * np.pi, (tufts, 1)) + np.arange(BLADES) * 2.1
    length = height * rng.uniform(0.35, 1.0, (tufts, 1)) * rng.uniform(0.6, 1.0, (tufts, BLADES))
    lean = rng.uniform(0.15, 0.8, (tufts, BLADES))
    half = 0.1 * height + 0.06 * length
    out = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    side = np.stack([-np.sin(azimuth), np.cos(azimuth)], axis=-1)
    corners = np.zeros((tufts, BLADES, 3, 3))
    corners[..., :2] = root[:, None, None] + 0.15 * height * out[:, :, None]
    corners[:, :, 0, :2] -= half[..., None] * side
    corners[:, :, 1, :2] += half[..., None] * side
    corners[:, :, 2, :2] += (lean * length)[..., None] * out
    corners[:, :, 2, 2] = length
    # Lit like the lawn they stand on.
    normals = np.zeros_like(corners)
    normals[..., :2], normals[..., 2] = 0.35 * out[:, :, None], 1.0
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    uv = np.empty((tufts, BLADES, 3, 2))
    uv[..., 0] = rng.uniform(0, _TEXTURE[0], (tufts, BLADES, 1))
    uv[..., 0] += [-0.012, 0.012, 0.0]
    uv[..., 1] = [0.95 * _TEXTURE[1], 0.95 * _TEXTURE[1], 0.05 * _TEXTURE[1]]
    count = tufts * BLADES
    return Mesh(
        corners.reshape(-1, 3).astype(np.float32),
        normals.reshape(-1, 3).astype(np.float32),
        uv.reshape(-1, 2).astype(np.float32),
        np.arange(3 * count, dtype=np.int32).reshape(-1, 3),
        np.repeat(rng.integers(2, size=tufts), BLADES).astype(np.int32),
        (_GRASS, _DARKER),
    )
