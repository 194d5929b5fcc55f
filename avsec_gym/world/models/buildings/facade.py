"""Walls with openings: bands of different material, cut where windows and doors are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.buildings.panels import (
    Floats,
    Panels,
    boxes,
    fan,
    quads,
    solid,
    upright,
)

BELOW_GROUND = -0.6
"""How deep walls reach, metres, so that no gap opens on a slope."""

NO_OPENINGS = np.zeros((0, 4))


class Band(NamedTuple):
    """A horizontal strip of a wall."""

    low: float
    """Metres above the ground."""
    high: float
    material: Material
    out: float = 0.0
    """How far it stands in front of the facade's plane, metres: plinths and cornices."""


def wall(
    length: float,
    bands: Sequence[Band],
    openings: Floats = NO_OPENINGS,
    *,
    adjoining: bool = False,
) -> list[Panels]:
    """A wall along x that faces -y, from -length / 2 to length / 2.

    Args:
        length: Length of the wall, metres.
        bands: Bands from the ground up, each beginning where the last one ends; textures hang from
            a band's upper edge.
        openings: Left, right, lower and upper end of each, shape (n, 4); they must not overlap.
        adjoining: Bands that stand out end with the wall, because the next house begins there;
            else they go round the corners.
    """
    parts: list[Panels] = []
    below: tuple[Band, list[tuple[float, float]]] | None = None
    cuts = sorted(openings.tolist())
    for band in bands:
        half = 0.5 * length + (0.0 if adjoining else band.out)
        ends = {min(max(end, band.low), band.high) for cut in cuts for end in cut[2:]}
        rows: list[tuple[float, float, float, float]] = []
        bottom: list[tuple[float, float]] = []
        for low, high in pairwise(sorted({band.low, band.high, *ends})):
            middle = 0.5 * (low + high)
            cut_here = [cut for cut in cuts if cut[2] < middle < cut[3]]
            starts = [-half, *(cut[1] for cut in cut_here)]
            stops = [*(cut[0] for cut in cut_here), half]
            spans = [
                (start, stop)
                for start, stop in zip(starts, stops, strict=True)
                if stop - start > 1e-6
            ]
            rows += [(start, end, low, high) for start, end in spans]
            bottom = bottom or spans
        face = upright(band.material, *np.array(rows).T, y=-band.out)
        parts.append(replace(face, uv=np.add(face.uv, (0.0, band.high))))
        if adjoining and band.out > 0:
            low, high = (-half, -band.out, band.low), (half, 0.0, band.high)
            hidden = ("front", "back", "top", "bottom")
            parts.append(boxes(band.material, low, high, without=hidden))
        if below is not None:
            parts += _ledge(below[0], below[1], band, bottom)
        below = band, spans
    if below is not None and below[0].out > 0:
        top = below[0]._replace(low=below[0].high, out=0.0)
        parts += _ledge(below[0], below[1], top, below[1])
    return parts


def gable(
    length: float, eaves: float, rise: float, material: Material, opening: Floats = NO_OPENINGS
) -> list[Panels]:
    """The triangle between eaves and ridge, facing -y.

    Args:
        length: Length of the wall below, metres.
        eaves: The height, metres.
        rise: Height from eaves to ridge, metres.
        material: Material of the wall.
        opening: Opening inside the triangle, its middle at x = 0, or none; shape (1, 4) or (0, 4).
    """
    half, peak = 0.5 * length, eaves + rise
    if not len(opening):
        return [fan(material, [(-half, 0.0, eaves), (half, 0.0, eaves), (0.0, 0.0, peak)])]
    _, x, low, high = opening[0]
    slant = peak - rise * x / half
    return [
        fan(material, [(-half, 0.0, eaves), (-x, 0.0, eaves), (-x, 0.0, slant)]),
        fan(material, [(x, 0.0, eaves), (half, 0.0, eaves), (x, 0.0, slant)]),
        fan(
            material,
            [(-x, 0.0, high), (x, 0.0, high), (x, 0.0, slant), (0.0, 0.0, peak), (-x, 0.0, slant)],
        ),
        upright(material, -x, x, eaves, low),
    ]


def enclose(width: float, depth: float, sides: Sequence[Sequence[Panels]]) -> Mesh:
    """Four facades round a footprint: towards the street, right, rear, left.

    Args:
        width: Width of the footprint, along x, metres.
        depth: Depth of the footprint, metres.
        sides: Meshes of the sides, each built for a wall along x that faces -y, its middle at the
            origin.
    """
    half = 0.5 * width
    places = [
        (0.0, 0.0, 0.0),
        (half, 0.5 * depth, 0.5),
        (0.0, depth, 1.0),
        (-half, 0.5 * depth, -0.5),
    ]
    return merge(
        [
            solid(parts).placed(x, y, yaw=turn * np.pi)
            for parts, (x, y, turn) in zip(sides, places, strict=True)
        ]
    )


def grid(columns: ArrayLike, sills: ArrayLike, width: float, height: float) -> Floats:
    """Openings of one size in columns and rows, shape (columns * rows, 4).

    Args:
        columns: Middles of the columns along the wall, metres.
        sills: Lower ends of the rows, metres.
        width: Width of each opening, metres.
        height: Height of each opening, metres.
    """
    x, z = (axis.ravel() for axis in np.meshgrid(columns, sills))
    return np.stack([x - 0.5 * width, x + 0.5 * width, z, z + height], axis=1)


def evenly(length: float, pitch: float, most: int = 6) -> Floats:
    """Middles of windows, about `pitch` apart, over a wall of this length."""
    count = int(np.clip(round(length / pitch), 1, most))
    return (np.arange(count) - 0.5 * (count - 1)) * (length / count)


def _ledge(
    below: Band, under: list[tuple[float, float]], above: Band, over: list[tuple[float, float]]
) -> list[Panels]:
    """The step between two bands, seen from above or from below."""
    step = below.out - above.out
    if abs(step) < 1e-6:
        return []
    near, far, z = -max(below.out, above.out), -min(below.out, above.out), below.high
    spans, material = (under, below.material) if step > 0 else (over, above.material)
    corners = [((a, near, z), (b, near, z), (b, far, z), (a, far, z)) for a, b in spans]
    order = [0, 1, 2, 3] if step > 0 else [3, 2, 1, 0]
    return [quads(material, np.array(corners).reshape(-1, 4, 3)[:, order])]
