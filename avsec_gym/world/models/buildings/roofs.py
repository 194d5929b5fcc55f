"""Roofs: closed and thick, with eaves, gutters and chimneys."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.world.material import Material
from avsec_gym.world.models.buildings.panels import Floats, Panels, boxes, fan, quads, slab

THICKNESS = 0.18
"""Thickness of a roof, vertical, metres."""


@dataclass(frozen=True)
class RoofMaterials:
    """What a roof is made of."""

    tiles: Material
    board: Material
    """Fascia, verges and soffits."""
    gutter: Material


def swept_roof(
    profile: ArrayLike, left: float, right: float, materials: RoofMaterials
) -> list[Panels]:
    """A roof of one cross-section from `left` to `right`: gable, mansard, lean-to.

    Args:
        profile: Points y and z of its upper side from the street to the rear, shape (n, 2).
        left: Position of the left end, metres.
        right: Position of the right end, metres.
        materials: Materials of the roof.
    """
    line = np.asarray(profile, float)
    parts: list[Panels] = []
    last = len(line) - 2
    for number, (near, far) in enumerate(pairwise(line)):
        corners = np.array([(left, *near), (right, *near), (right, *far), (left, *far)])
        near_edge, far_edge = 0, 2
        if far[1] < near[1]:
            # Tiles lie with their lower edge towards the eaves, which comes first.
            corners, near_edge, far_edge = corners[[2, 3, 0, 1]], 2, 0
        edges = (1, 3) + (near_edge,) * (number == 0) + (far_edge,) * (number == last)
        parts += slab(
            materials.tiles,
            corners,
            THICKNESS,
            under=materials.board,
            edge=materials.board,
            edges=edges,
        )
    top = int(np.argmax(line[:, 1]))
    if 0 < top < len(line) - 1:
        y, z = line[top]
        parts.append(_ridge_cap(materials.tiles, left - 0.02, right + 0.02, y, z))
    return parts


def gable_profile(depth: float, eaves: float, rise: float, overhang: float) -> Floats:
    """Cross-section of a gabled roof whose underside meets the walls at height `eaves`."""
    slope = rise / (0.5 * depth)
    low, high = eaves + THICKNESS - overhang * slope, eaves + THICKNESS + rise
    return np.array([(-overhang, low), (0.5 * depth, high), (depth + overhang, low)])


def mansard_profile(depth: float, eaves: float, lower: float, rise: float) -> Floats:
    """A steep lower slope of height `lower`, then a flat upper one."""
    z, steep, overhang = eaves + THICKNESS, 0.3 * lower, 0.05
    drop = overhang * lower / steep
    return np.array(
        [
            (-overhang, z - drop),
            (steep, z + lower),
            (0.5 * depth, z + lower + rise),
            (depth - steep, z + lower),
            (depth + overhang, z - drop),
        ]
    )


def end_wall(material: Material, profile: Floats, eaves: float, depth: float) -> list[Panels]:
    """The wall between eaves and roof at the left and the right end of a swept roof.

    Returns:
        Panels in the plane x = 0 facing -x (first) and +x (second).
    """
    under = profile - (0.0, THICKNESS)
    inner = under[(under[:, 0] > 0) & (under[:, 0] < depth)]
    outline = np.array([(0.0, eaves), *inner, (depth, eaves)])
    points = np.c_[np.zeros(len(outline)), outline]
    return [fan(material, points), fan(material, points[::-1])]


def hip_roof(
    width: float, depth: float, eaves: float, rise: float, overhang: float, materials: RoofMaterials
) -> list[Panels]:
    """Four planes over walls of width x depth that end at `eaves`."""
    slope = rise / (0.5 * min(width, depth))
    low, high = eaves + THICKNESS - overhang * slope, eaves + THICKNESS + rise
    x, y0, y1 = 0.5 * width + overhang, -overhang, depth + overhang
    corners = np.array([(-x, y0, low), (x, y0, low), (x, y1, low), (-x, y1, low)])
    if width >= depth:
        inset = 0.5 * (depth - width)
        ridge = np.array([(inset, 0.5 * depth, high), (-inset, 0.5 * depth, high)])
        tops = [(ridge[1], ridge[0]), (ridge[1],) * 2, (ridge[0], ridge[1]), (ridge[0],) * 2]
    else:
        inset = 0.5 * width
        ridge = np.array([(0.0, inset, high), (0.0, depth - inset, high)])
        tops = [(ridge[0],) * 2, (ridge[1], ridge[0]), (ridge[1],) * 2, (ridge[0], ridge[1])]
    parts: list[Panels] = []
    for side in range(4):
        plane = np.array([corners[side], corners[(side + 1) % 4], *tops[side]])
        parts += slab(
            materials.tiles,
            plane,
            THICKNESS,
            under=materials.board,
            edge=materials.board,
            edges=(0,),
        )
    if width > depth:
        parts.append(_ridge_cap(materials.tiles, ridge[0, 0], ridge[1, 0], 0.5 * depth, high))
    return parts


def flat_roof(
    width: float, depth: float, height: float, rim: Material, top: Material, overhang: float = 0.05
) -> list[Panels]:
    """A rim that covers the walls' upper ends, and gravel 0.1 m below its edge."""
    x, low, high = 0.5 * width + overhang, height - 0.05, height + 0.25
    y0, y1, edge = -overhang, depth + overhang, 0.3
    ring = boxes(
        rim,
        [(-x, y0, low), (-x, y1 - edge, low), (-x, y0 + edge, low), (x - edge, y0 + edge, low)],
        [(x, y0 + edge, high), (x, y1, high), (edge - x, y1 - edge, high), (x, y1 - edge, high)],
    )
    inner = (x - edge, y0 + edge, y1 - edge, high - 0.1)
    return [ring, _level(top, *inner)]


def gutters(
    material: Material, left: float, right: float, front: float, rear: float, z: float
) -> Panels:
    """Before the eaves at y = front and behind those at y = rear, upper edges at z."""
    low = np.array([(left, front - 0.13, z - 0.11), (left, rear, z - 0.11)])
    return boxes(material, low, np.add(low, (right - left, 0.13, 0.11)))


def chimney(
    x: float, y: float, low: float, high: float, body: Material, cap: Material
) -> list[Panels]:
    """A stack of 0.7 m x 0.5 m from inside the roof, with a slab on top."""
    size = np.array([0.35, 0.25])
    start, end = (x - size[0], y - size[1]), (x + size[0], y + size[1])
    return [
        boxes(body, (*start, low), (*end, high), without=("bottom",)),
        boxes(
            cap,
            (start[0] - 0.06, start[1] - 0.06, high),
            (end[0] + 0.06, end[1] + 0.06, high + 0.1),
        ),
    ]


def _ridge_cap(tiles: Material, left: float, right: float, y: float, z: float) -> Panels:
    """A row of round tiles, as a low ridge."""
    ends = [(y - 0.16, z - 0.04), (y, z + 0.06), (y + 0.16, z - 0.04)]
    front = [(left, *ends[0]), (right, *ends[0]), (right, *ends[1]), (left, *ends[1])]
    rear = [(right, *ends[2]), (left, *ends[2]), (left, *ends[1]), (right, *ends[1])]
    return quads(tiles, [front, rear])


def _level(material: Material, x: float, y0: float, y1: float, z: float) -> Panels:
    return quads(material, [[(-x, y0, z), (x, y0, z), (x, y1, z), (-x, y1, z)]])
