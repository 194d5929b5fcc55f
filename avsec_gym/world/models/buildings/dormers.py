"""Windows in roofs: dormers and skylights on the slope that faces the street."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.models.buildings.panels import Floats, Panels, fan, quads, slab, upright
from avsec_gym.world.models.buildings.roofs import RoofMaterials
from avsec_gym.world.models.buildings.windows import pane_material

_BORDER, _OVERHANG = 0.12, 0.15


class Slope(NamedTuple):
    """The upper side of the roof towards the street."""

    eaves: float
    """Its height over the facade's plane, metres."""
    rise: float
    """Metres per metre."""


def dormers(
    columns: Floats,
    front: float,
    slope: Slope,
    size: tuple[float, float],
    cheeks: Material,
    frame: Material,
    materials: RoofMaterials,
    pane: int,
    *,
    gabled: bool,
) -> list[Panels]:
    """Little houses on the roof, each with a window of two sashes.

    Args:
        columns: Middles of the dormers along x, shape (n,).
        front: Distance of their fronts behind the facade, metres.
        slope: Slope of the roof.
        size: Width and height of their fronts up to the eaves, metres.
        cheeks: Material of fronts and sides.
        frame: Material of the windows.
        materials: Materials of their roofs.
        pane: Variant of the window glass.
        gabled: Whether each has a small gable; else a roof that falls gently forwards.
    """
    half, low = 0.5 * size[0], slope.eaves + front * slope.rise
    high = low + size[1]
    tilt = 0.0 if gabled else 0.18 * slope.rise
    reach = front + size[1] / (slope.rise - tilt)
    cheek = np.array([(front, low), (front, high), (reach, high + tilt * (reach - front))])
    parts = [
        fan(cheeks, np.c_[np.full(3, -half), cheek]),
        fan(cheeks, np.c_[np.full(3, half), cheek][::-1]),
        upright(cheeks, -half, half, low - 0.1, high, y=front),
        *_window(half, low, high, front, frame, pane),
    ]
    if gabled:
        peak = high + 0.75 * half
        parts.append(fan(cheeks, [(-half, front, high), (half, front, high), (0, front, peak)]))
        end = front + (peak - low) / slope.rise
        parts += _gable_roof(half, (high, peak), (front - _OVERHANG, reach, end), materials)
    else:
        x, near, far = half + _OVERHANG, front - _OVERHANG, reach + 0.1
        start, end = (high + (y - front) * tilt + 0.08 for y in (near, far))
        plane = [(-x, near, start), (x, near, start), (x, far, end), (-x, far, end)]
        parts += _thin(plane, (0, 1, 3), materials)
    return _repeated(parts, columns)


def skylights(columns: Floats, y: float, slope: Slope, frame: Material) -> list[Panels]:
    """Roof windows of 0.8 m x 1.2 m, their lower ends `y` behind the facade."""
    length = 1.2 / np.hypot(1.0, slope.rise)

    def plane(margin: float, lift: float) -> list[tuple[float, float, float]]:
        x, near, far = 0.4 - margin, y + margin, y + length - margin
        low, high = (slope.eaves + end * slope.rise + lift for end in (near, far))
        return [(-x, near, low), (x, near, low), (x, far, high), (-x, far, high)]

    glass = quads(
        Material("plain", (0.02, 0.025, 0.03), mirror=0.1, infrared=0.05), plane(0.07, 0.1)
    )
    return _repeated(
        [*slab(frame, plane(0.0, 0.09), 0.14, under=frame, edge=frame), glass], columns
    )


def _window(
    half: float, low: float, high: float, front: float, frame: Material, pane: int
) -> list[Panels]:
    """A board with two panes before it."""
    x, z0, z1 = half - _BORDER, low + 0.2, high - _BORDER
    left, right = np.array([-x + 0.07, 0.04]), np.array([-0.04, x - 0.07])
    return [
        upright(frame, -x, x, z0, z1, y=front - 0.03),
        upright(pane_material(pane), left, right, z0 + 0.07, z1 - 0.07, y=front - 0.045, once=True),
    ]


def _gable_roof(
    half: float,
    heights: tuple[float, float],
    depths: tuple[float, float, float],
    materials: RoofMaterials,
) -> list[Panels]:
    """Two planes over (eaves, peak), from the front to where eaves and ridge meet the slope."""
    near, far, end = depths
    x = half + _OVERHANG
    low, high = heights[0] - 0.75 * _OVERHANG + 0.08, heights[1] + 0.08
    left = [(-x, far, low), (-x, near, low), (0.0, near, high), (0.0, end, high)]
    right = [(x, near, low), (x, far, low), (0.0, end, high), (0.0, near, high)]
    return _thin(left, (0, 1), materials) + _thin(right, (0, 3), materials)


def _thin(
    plane: list[tuple[float, float, float]], edges: tuple[int, ...], materials: RoofMaterials
) -> list[Panels]:
    board = materials.board
    return slab(materials.tiles, plane, 0.12, under=board, edge=board, edges=edges)


def _repeated(parts: list[Panels], columns: Floats) -> list[Panels]:
    places = np.c_[columns, np.zeros((len(columns), 2))]
    return [part.at(places) for part in parts]
