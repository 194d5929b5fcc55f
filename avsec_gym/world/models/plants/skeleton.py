"""Trunk and branches, grown from the ground to the clusters of leaves.

Each cluster is joined to the nearest point of what has grown already, a way that goes down
counting as longer; then the pipe rule gives the girths: a branch is as thick as what it bears.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.shapes import tube

Floats = NDArray[np.float64]

_PIPE_EXPONENT = 2.2
_DOWNWARDS = 1.6
_SAG = 0.12


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A tree of n points; point 0 stands on the ground."""

    points: Floats
    """Metres, shape (n, 3)."""
    parent: NDArray[np.intp]
    """Of each point, shape (n,); -1 for the ground."""
    radius: Floats
    """Metres, shape (n,)."""
    trunk: int
    """The first so many points are the trunk, from the bottom up."""


def grow(trunk: Floats, goals: Floats, girth: float) -> Skeleton:
    """Branches from a trunk to all goals.

    Args:
        trunk: Points from the ground up, shape (m, 3), metres.
        goals: Where branches end, shape (n, 3).
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
    return Skeleton(np.array(points), np.array(parent), radius, len(trunk))


def wood(skeleton: Skeleton, bark: Material, *, sides: int, thinnest: float) -> Mesh:
    """Trunk and branches as tubes.

    Args:
        skeleton: What has grown.
        bark: Their material.
        sides: Of the trunk's cross-section.
        thinnest: Branches of a smaller radius are left out, metres.
    """
    points, radius, trunk = skeleton.points, skeleton.radius.copy(), skeleton.trunk
    radius[0] *= 1.3  # the roots' flare
    parts = [tube(points[:trunk], radius[:trunk], bark, sides=sides, capped=False)]
    for middle in range(trunk, len(points), 2):
        root = skeleton.parent[middle]
        if radius[middle] >= thinnest:
            sizes = [min(radius[root], 1.25 * radius[middle]), radius[middle], 0.4 * radius[middle]]
            way = points[[root, middle, middle + 1]]
            parts.append(tube(way, sizes, bark, sides=3 if radius[middle] < 0.04 else sides - 3, capped=False))
    return merge(parts)
