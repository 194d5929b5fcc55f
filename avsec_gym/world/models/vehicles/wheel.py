"""Wheels: a tyre round a dished rim whose spokes are a texture."""

from __future__ import annotations

import functools

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.vehicles.hull import surface
from avsec_gym.world.models.vehicles.paint import RUBBER

RIMS = 8
"""Number of rim textures."""

_SIDES = 22


@functools.cache
def wheel(rim: int, share: float = 0.66) -> Mesh:
    """A left wheel of radius 1 and width 0.62, its outer face at y = 0, its centre at the origin.

    Args:
        rim: Number of the rim's texture.
        share: Radius of the rim.
    """
    # Radius and y, from the inner side over the tread to the rim's edge and the hub.
    tyre = [(0.90, -0.62), (1.0, -0.54), (1.0, -0.10), (0.94, -0.015), (share, 0.0)]
    dish = [(share, 0.0), (share - 0.05, -0.06), (0.30, -0.10), (1e-3, -0.06)]
    material = Material(f"wheel/{rim}", mirror=0.06, infrared=0.35)
    inner = [(1e-3, -0.55), (0.90, -0.62)]
    parts = [_turned(tyre, RUBBER), _turned(inner, RUBBER), _turned(dish, material)]
    return merge(parts)


def _turned(profile: list[tuple[float, float]], material: Material) -> Mesh:
    """A profile turned about the y axis; the texture, 2 by 2, lies on x and z."""
    line = np.array(profile)
    angle = np.linspace(0.0, 2.0 * np.pi, _SIDES + 1)
    radius, y = line[:, :1], line[:, 1:]
    points = np.stack(
        [
            radius * np.cos(angle),
            np.broadcast_to(y, (len(line), _SIDES + 1)),
            radius * np.sin(angle),
        ],
        axis=-1,
    )
    along = np.gradient(line, axis=0)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across /= -np.linalg.norm(across, axis=1, keepdims=True)
    normals = np.stack(
        [
            -across[:, :1] * np.cos(angle),
            np.broadcast_to(-across[:, 1:], (len(line), _SIDES + 1)),
            -across[:, :1] * np.sin(angle),
        ],
        axis=-1,
    )
    uv = 1.0 - points[..., [0, 2]]
    return surface(points[:, ::-1], normals[:, ::-1], material, uv[:, ::-1])
