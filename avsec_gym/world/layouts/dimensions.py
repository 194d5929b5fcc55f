"""What the objects of a layout are and how large: category mixes and sizes matched to KITTI.

The sizes are mixtures of Gaussians, one component for each body type (small car, tall car,
panel van, articulated truck, trailer ...), fitted to KITTI's labels.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats

Codes = NDArray[np.int64]
"""Indices into `CATEGORIES`, shape (N,)."""

CATEGORIES = np.array(["Car", "Van", "Truck", "Misc", "Pedestrian", "Cyclist"])

_BODIES: Mapping[str, tuple[tuple[float, ...], ...]] = {
    # share, mean of height, width, length, standard deviation of each; metres
    "Car": (
        (0.45, 1.55, 1.66, 4.01, 0.13, 0.06, 0.34),
        (0.30, 1.45, 1.57, 3.72, 0.06, 0.05, 0.32),
        (0.18, 1.51, 1.59, 3.66, 0.09, 0.13, 0.48),
        (0.07, 1.74, 1.78, 4.42, 0.20, 0.10, 0.30),
    ),
    "Van": (
        (0.57, 1.97, 1.80, 4.48, 0.15, 0.12, 0.43),
        (0.43, 2.52, 2.04, 5.87, 0.21, 0.14, 0.51),
    ),
    "Truck": (
        (0.34, 3.00, 2.50, 7.30, 0.40, 0.20, 0.80),
        (0.59, 3.30, 2.64, 11.0, 0.38, 0.18, 0.90),
        (0.07, 4.04, 2.52, 16.5, 0.04, 0.04, 0.15),
    ),
    "Misc": (
        (0.67, 1.52, 1.15, 2.09, 0.40, 0.40, 0.46),
        (0.27, 2.38, 2.14, 4.70, 0.60, 0.16, 1.00),
        (0.06, 3.68, 2.62, 12.1, 0.20, 0.05, 0.46),
    ),
    "Pedestrian": ((1.0, 1.76, 0.66, 0.84, 0.11, 0.14, 0.23),),
    "Cyclist": ((1.0, 1.74, 0.60, 1.76, 0.09, 0.12, 0.18),),
}
_SMALLEST = np.array(
    [
        [1.27, 1.34, 2.7],
        [1.7, 1.54, 3.2],
        [2.32, 2.06, 5.4],
        [0.8, 0.45, 0.9],
        [1.48, 0.36, 0.3],
        [1.44, 0.36, 1.2],
    ]
)
_LARGEST = np.array(
    [
        [2.05, 1.94, 4.96],
        [2.91, 2.46, 6.9],
        [4.2, 3.0, 16.8],
        [3.9, 2.68, 12.6],
        [2.0, 1.04, 1.44],
        [1.98, 0.89, 2.12],
    ]
)

_ROWS = [(code, body) for code, name in enumerate(CATEGORIES) for body in _BODIES[str(name)]]
_BODY = np.array([body[1:] for _, body in _ROWS])
_FIRST_BODY = np.array([[code for code, _ in _ROWS].index(i) for i in range(len(CATEGORIES))])
_CUMULATIVE = np.ones((len(CATEGORIES), max(len(bodies) for bodies in _BODIES.values())))
for _code, _name in enumerate(CATEGORIES):
    _shares = [body[0] for body in _BODIES[str(_name)]]
    _CUMULATIVE[_code, : len(_shares) - 1] = np.cumsum(_shares[:-1])


class CategoryMix:
    """Shares of the categories among the objects of one row or lane.

    Args:
        shares: Relative frequency by category name; names left out do not occur.

    Example:
        >>> mix = CategoryMix(Car=9, Van=1)
        >>> CATEGORIES[mix.draw(np.random.default_rng(0), 3)].tolist()
        ['Car', 'Car', 'Car']
    """

    def __init__(self, **shares: float) -> None:
        known = np.array([shares.get(str(name), 0.0) for name in CATEGORIES])
        self._cumulative = np.cumsum(known / known.sum())[:-1]

    def draw(self, rng: np.random.Generator, count: int) -> Codes:
        """Categories of `count` objects, shape (count,)."""
        return np.asarray(self._cumulative.searchsorted(rng.random(count), side="right"))


def draw_dimensions(rng: np.random.Generator, codes: Codes) -> Floats:
    """Sizes for objects of known category.

    Args:
        rng: The source of chance.
        codes: Category codes, shape (N,).

    Returns:
        Height, width, length in metres, shape (N, 3).
    """
    beyond = rng.random(len(codes))[:, None] >= _CUMULATIVE[codes]
    body = _BODY[_FIRST_BODY[codes] + beyond.sum(axis=1)]
    sizes = body[:, :3] + body[:, 3:] * rng.standard_normal((len(codes), 3))
    return np.asarray(np.minimum(np.maximum(sizes, _SMALLEST[codes]), _LARGEST[codes]))
