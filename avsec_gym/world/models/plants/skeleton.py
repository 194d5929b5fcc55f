"""Trunk and branches, grown from the ground to the clusters of leaves.

Each cluster is joined to the nearest point of what has grown already, a way that goes down
counting as longer; then the pipe rule gives the girths: a branch is as thick as what it bears.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.shapes import tube

_PIPE_EXPONENT = 2.2
_DOWNWARDS = 1.6
_SAG = 0.12
_FLARE = 1.3
"""Flare of the trunk at its roots."""
_BRANCH_SIDES = 4


@dataclass(frozen=True, eq=False)
class TreeSkeleton:
    """A tree of n points; point 0 stands on the ground."""

    points: Floats
    """Metres, shape (n, 3)."""
    parent: NDArray[np.intp]
    """Parent of each point, shape (n,); -1 for the ground."""
    radius: Floats
    """Metres, shape (n,)."""
    trunk: int
    """The first so many points are the trunk, from the bottom up."""


def grow(trunk: Floats, goals: Floats, girth: float) -> TreeSkeleton:
    """Branches from a trunk to all goals.

    Args:
        trunk: Points from the ground up, shape (m, 3), metres.
        goals: End points of the branches, shape (n, 3).
        girth: Radius at the ground, metres.
    """
    points = [*trunk]
    parent = list(range(-1, len(trunk) - 1))
    lowest = int(0.3 * len(trunk))
    axis = trunk[:, :2].mean(axis=0)
    for goal in goals[np.argsort(np.linalg.norm(goals[:, :2] - axis, axis=1), kind="stable")]:
        grown = np.array(points)
        way = goal - grown
        cost = np.linalg.norm(way, axis=1) + _DOWNWARDS * np.maximum(0, -way[:, 2])
        cost[:lowest] = np.inf
        root = int(np.argmin(cost))
        bow = np.array([0, 0, -_SAG]) * np.linalg.norm(goal[:2] - points[root][:2])
        points += [0.5 * (points[root] + goal) + bow, goal]
        parent += [root, len(points) - 2]
    load = np.zeros(len(points))
    load[len(trunk) + 1 :: 2] = 1.0
    load[len(trunk) - 1] += 1.0
    for number in range(len(points) - 1, 0, -1):
        load[parent[number]] += load[number]
    radius = girth * (load / load[0]) ** (1 / _PIPE_EXPONENT)
    return TreeSkeleton(np.array(points), np.array(parent), radius, len(trunk))


def wood(skeleton: TreeSkeleton, bark: Material, *, sides: int, thinnest: float) -> Mesh:
    """Trunk and branches as tubes.

    Args:
        skeleton: The grown skeleton.
        bark: Material of trunk and branches.
        sides: Number of sides of the trunk's cross-section.
        thinnest: Branches of a smaller radius are left out, metres.
    """
    points, radius, trunk = skeleton.points, skeleton.radius.copy(), skeleton.trunk
    radius[0] *= _FLARE
    stem = tube(points[:trunk], radius[:trunk], bark, sides=sides, capped=False)
    middle = np.arange(trunk, len(points), 2)
    middle = middle[radius[middle] >= thinnest]
    if len(middle) == 0:
        return stem
    root = skeleton.parent[middle]
    way = points[np.stack([root, middle, middle + 1], axis=1)]
    own = radius[middle]
    sizes = np.stack([np.minimum(radius[root], 1.25 * own), own, 0.4 * own], axis=1)
    return merge([stem, _branches(way, sizes, bark)])


def _branches(way: Floats, radius: Floats, bark: Material) -> Mesh:
    """N tubes at once, each through 3 points: `way` of shape (n, 3, 3), `radius` (n, 3)."""
    along = unit(way[:, 2] - way[:, 0])
    first = unit(np.cross(along, [0.13, 0.29, 0.95]))
    second = np.cross(first, along)
    angle = np.linspace(0, 2 * np.pi, _BRANCH_SIDES + 1)[:, None]
    around = np.cos(angle) * first[:, None] + np.sin(angle) * second[:, None]
    points = way[:, :, None] + radius[:, :, None, None] * around[:, None]
    normals = np.broadcast_to(around[:, None], points.shape)
    length = np.linalg.norm(way - way[:, :1], axis=2)
    uv = np.stack(np.broadcast_arrays(angle[:, 0] * radius[:, :1, None], length[..., None]), -1)
    corner = np.arange(len(way) * 3 * len(angle), dtype=np.int32).reshape(-1, 3, len(angle))
    a, b = corner[:, :-1, :-1].ravel(), corner[:, 1:, :-1].ravel()
    c, d = corner[:, 1:, 1:].ravel(), corner[:, :-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Mesh(
        points.reshape(-1, 3).astype(np.float32),
        normals.reshape(-1, 3).astype(np.float32),
        uv.reshape(-1, 2).astype(np.float32),
        faces,
        np.zeros(len(faces), np.int32),
        (bark,),
    )


def unit(vectors: Floats) -> Floats:
    """Scaled to length 1 along the last axis."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))
