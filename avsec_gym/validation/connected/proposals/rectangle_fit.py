"""A rectangle about the near sides of an object: search-based L-shape fitting."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats

_HEADINGS = np.radians(np.arange(0.0, 90.0, 3.0))
_NEAREST = 0.05
"""Metres: points nearer to a side than this are on it."""
_CELL = 0.05
_NARROWEST = 0.1


def fitted_rectangle(places: Floats) -> Floats:
    """The rectangle of whose sides the points are nearest to the two that they are on.

    Zhang et al., "Efficient L-shape fitting for vehicle detection using laser scanners", IV 2017,
    with its closeness criterion.

    Args:
        places: Points on the ground plane, metres, shape (N, 2), N at least 1.

    Returns:
        x, y, length, width, heading; the length is the longer side.

    Example:
        >>> side, end = np.linspace(0, 4, 41), np.linspace(0, 2, 21)
        >>> corner = np.r_[np.c_[side, 0 * side], np.c_[0 * end, end]]
        >>> fitted_rectangle(corner).round(2).tolist()
        [2.0, 1.0, 4.0, 2.0, 0.0]
    """
    # How often a place was hit is no property of the shape.
    places = np.unique(np.round(places / _CELL), axis=0) * _CELL
    cos, sin = np.cos(_HEADINGS)[:, None], np.sin(_HEADINGS)[:, None]
    along = cos * places[:, 0] + sin * places[:, 1]
    across = cos * places[:, 1] - sin * places[:, 0]
    away = np.minimum(_to_nearer_end(along), _to_nearer_end(across))
    best = int(np.argmax((1 / np.maximum(away, _NEAREST)).sum(axis=1)))
    low = np.array([along[best].min(), across[best].min()])
    high = np.array([along[best].max(), across[best].max()])
    length, width = np.maximum(high - low, _NARROWEST)
    cos, sin = np.cos(_HEADINGS[best]), np.sin(_HEADINGS[best])
    u, v = (low + high) / 2
    heading = float(_HEADINGS[best])
    if length < width:
        length, width, heading = width, length, heading + np.pi / 2
    return np.array([cos * u - sin * v, sin * u + cos * v, length, width, heading])


def _to_nearer_end(values: Floats) -> Floats:
    """Distance of each value to the end of its row's range that is nearer, shape (K, N)."""
    low, high = values.min(axis=1, keepdims=True), values.max(axis=1, keepdims=True)
    return np.minimum(values - low, high - values)
