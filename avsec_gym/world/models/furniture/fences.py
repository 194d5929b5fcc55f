"""Fences and railings along a path."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.facets import facets
from avsec_gym.world.models.furniture.materials import GALVANISED, painted
from avsec_gym.world.models.furniture.poles import DEPTH
from avsec_gym.world.models.furniture.sweep import along, copies, lengths, located, swept
from avsec_gym.world.shapes import box, tube

GREEN_COATED = painted(0.03, 0.09, 0.05)
DARK_COATED = painted(0.03, 0.035, 0.035)


def bar_fence(
    path: ArrayLike, *, height: float = 1.2, material: Material = DARK_COATED, pitch: float = 0.13
) -> Mesh:
    """Upright bars between two rails, posts every 2.5 m: garden fence, bridge railing.

    Args:
        path: Points on the ground, shape (n, 3), metres.
        height: Height of the upper rail, metres.
        material: Material of all parts.
        pitch: Distance from bar to bar, metres.
    """
    bar = tube([(0, 0, 0.08), (0, 0, height)], 0.011, material, sides=3, capped=False)
    post = box(0.05, 0.05, height + 0.02 + DEPTH, material).placed(0, 0, -DEPTH)
    rails = [
        swept(_raised(path, z), _square(half), material)
        for z, half in ((0.1, 0.015), (height - 0.02, 0.022))
    ]
    return merge([*rails, copies(bar, along(path, pitch)), copies(post, along(path, 2.5))])


def chain_link_fence(
    path: ArrayLike, *, height: float = 1.6, material: Material = GREEN_COATED, pitch: float = 0.14
) -> Mesh:
    """A net of diagonal wires between posts, a tension wire above and below.

    Args:
        path: Points on the ground, shape (n, 3), metres.
        height: Height of the fence, metres.
        material: Material of all parts.
        pitch: Width of the meshes, metres; wider than real ones, whose wires a camera cannot
            resolve.
    """
    post = box(0.05, 0.05, height + 0.03 + DEPTH, GALVANISED).placed(0, 0, -DEPTH)
    edges = [swept(_raised(path, z), _square(0.006), material) for z in (0.05, height)]
    return merge([_net(path, height, material, pitch), copies(post, along(path, 2.5)), *edges])


def tube_railing(path: ArrayLike, *, height: float = 1.0, material: Material = GALVANISED) -> Mesh:
    """A handrail and a knee rail on posts every 2 m: footpaths, traffic islands."""
    post = box(0.045, 0.045, height + DEPTH, material).placed(0, 0, -DEPTH)
    rails = [swept(_raised(path, z), _square(0.024), material) for z in (0.5 * height, height)]
    return merge([copies(post, along(path, 2.0)), *rails])


def _raised(path: ArrayLike, height: float) -> np.ndarray:
    return np.add(path, (0.0, 0.0, height))


def _square(half: float) -> np.ndarray:
    return half * np.array([(1, -1), (1, 1), (-1, 1), (-1, -1)])


def _net(path: ArrayLike, height: float, material: Material, pitch: float) -> Mesh:
    """Wires at 45 degrees in both directions: strips of 8 mm that face across the path."""
    length = float(lengths(path)[-1])
    start = np.arange(-height + 0.5 * pitch, length, pitch)
    low, high = np.maximum(0.0, -start), np.minimum(height, length - start)
    rows = []
    for side in (-0.004, 0.004):
        for up in (low, high):
            rows.append(np.column_stack([located(path, start + up + side), up]))
            rows.append(np.column_stack([located(path, length - start - up - side), up]))
    points = np.array(rows).reshape(2, 2, 2, -1, 4)
    points[..., 2] += points[..., 3]
    strips = np.concatenate([points[0, 0], points[1, 0], points[1, 1], points[0, 1]], axis=-1)
    return facets(strips.reshape(-1, 4, 4)[..., :3], material)
