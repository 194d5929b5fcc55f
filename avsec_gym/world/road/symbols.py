"""Shapes painted on lanes: arrows, a bicycle, digits."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats

STROKES: dict[str, tuple[float, list[Floats]]] = {}
"""The strokes of each symbol and their width: places ahead and to the left of its middle as a
driver comes to it, metres, each of shape (n, 2)."""


def _arc(
    centre: tuple[float, float], radii: tuple[float, float], first: float, last: float
) -> Floats:
    angle = np.radians(np.linspace(first, last, 17))
    return np.array(centre) + np.array(radii) * np.stack([np.cos(angle), np.sin(angle)], -1)


def _lines(*points: tuple[float, float]) -> Floats:
    return np.array(points, float)


_WHEEL = (0.34, 0.3)
STROKES["bicycle"] = (
    0.06,
    [
        _arc((0.0, 0.52), _WHEEL, 0, 360),
        _arc((0.0, -0.52), _WHEEL, 0, 360),
        _lines((0.0, 0.52), (0.5, 0.3), (0.5, -0.35), (0.0, -0.52)),
        _lines((0.0, 0.52), (0.02, 0.05), (0.5, 0.3)),
        _lines((0.02, 0.05), (0.5, -0.35)),
        _lines((0.5, 0.3), (0.62, 0.26), (0.62, 0.14), (0.62, 0.36)),
        _lines((0.5, -0.35), (0.72, -0.4), (0.74, -0.52)),
    ],
)
STROKES["30"] = (
    0.14,
    [
        _arc((0.5, 0.4), (0.5, 0.26), 60, -180),
        _arc((-0.5, 0.4), (0.5, 0.26), 0, -240),
        _arc((0.0, -0.4), (1.0, 0.26), 0, 360),
    ],
)

ARROWS: dict[str, Floats] = {
    "straight": _lines(
        (-2.5, -0.08),
        (1.0, -0.08),
        (1.0, -0.32),
        (2.5, 0.0),
        (1.0, 0.32),
        (1.0, 0.08),
        (-2.5, 0.08),
    ),
    "left": _lines(
        (-2.5, -0.08),
        (0.7, -0.08),
        (1.45, 0.42),
        (1.95, 0.42),
        (1.3, 1.0),
        (0.55, 0.42),
        (1.05, 0.42),
        (0.55, 0.08),
        (-2.5, 0.08),
    ),
}
"""Polygons, in the strokes' coordinates; an arrow to the right is the left one mirrored."""
ARROWS["right"] = ARROWS["left"] * [1.0, -1.0]


def placed(shape: Floats, along: float, left: float, direction: int) -> Floats:
    """Road coordinates of a symbol's places in a lane of that direction."""
    return np.asarray(np.array([along, left]) + direction * shape)
