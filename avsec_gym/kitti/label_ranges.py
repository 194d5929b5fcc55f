"""What the numbers of a label or result line can be; those of `DontCare` are placeholders."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.image_only import NOWHERE

FARTHEST = 1000.0
"""Metres; no sensor of a car sees an object beyond, and -1000 is KITTI's place of no object."""

HIGHEST = 100.0
"""Metres above or below the camera; results without a place are written at -999, too."""

LARGEST_LABEL = np.array([10.0, 10.0, 50.0])
"""Height, width, length, metres: KITTI's largest are a truck of 4.2 x 3.0 m, a tram of 35.2 m."""

LARGEST_RESULT = np.array([20.0, 100.0, 100.0])
"""The same of a detector's results: it may be wrong by as much again, and take width for length."""

_UNKNOWN_ANGLE = -10.0
# KITTI gives angles in [-pi, pi], rounded. Detectors add some without taking turns off: their
# headings are known up to pi, and two of them are summed.
_LARGEST_ANGLE = {"label": np.pi + 0.01, "result": 4 * np.pi}
_MOST_OCCLUDED = 3
_TRUNCATION, _OCCLUSION = 0, 1
_ANGLES, _SIZES, _METRES = [2, 13], slice(7, 10), slice(7, 13)
_PLACEHOLDERS = np.array([-1.0, _UNKNOWN_ANGLE, _UNKNOWN_ANGLE])
_LOCATION, _HEIGHT = slice(10, 13), 11
_LEAST = np.array([-1.0, -1.0, -np.inf, *[-np.inf] * 4, *[-FARTHEST] * 6, -np.inf])
_MOST = np.array([1.0, _MOST_OCCLUDED, 0.0, *[np.inf] * 4, *[FARTHEST] * 6, 0.0])


def all_possible(values: Floats, *, result: bool, tracking: bool = False) -> bool:
    """Whether every number can be, seen at a glance; `impossibility` names what is wrong.

    Args:
        values: The columns after the category, shape (N, 14) or more; no ``DontCare``.
        result: Whether it is a detector's result, whose angles may have turns too many.
        tracking: Whether it is of the tracking benchmark, whose truncation is a level from 0 to 2.
    """
    largest = _LARGEST_ANGLE["result" if result else "label"]
    most = np.array([2.0 if tracking else 1.0, *_MOST[1:]])
    most[_ANGLES] = largest
    most[_SIZES] = LARGEST_RESULT if result else LARGEST_LABEL
    if (values[:, :14] > most).any() or (values[:, :14] < _LEAST).any():
        return False
    # Between a placeholder and the smallest real value there is nothing.
    gapped = values[:, [_TRUNCATION, *_ANGLES]]
    between = (gapped < [0.0, -largest, -largest]) & (gapped != _PLACEHOLDERS)
    backwards = values[:, 5:7] < values[:, 3:5]
    aloft = np.abs(values[:, _HEIGHT]) > HIGHEST
    aloft &= (values[:, _LOCATION] != NOWHERE).any(axis=1)
    wrong = between.any() or backwards.any() or aloft.any()
    return not (wrong or (values[:, _OCCLUSION] % 1).any())


def impossibility(
    name: str, row: Sequence[float], *, result: bool, tracking: bool = False
) -> str | None:
    """What of a line cannot be, in a sentence; None where all of it can.

    Args:
        name: The category.
        row: The numbers after it.
        result: Whether it is a detector's result, as of `all_possible`.
        tracking: Whether it is of the tracking benchmark, as of `all_possible`.
    """
    truncation, occlusion, left, top, right, bottom = (row[i] for i in (0, 1, 3, 4, 5, 6))
    if right < left or bottom < top:
        return (
            f"The 2D box of a {name} ends at ({right:g}, {bottom:g}) before it begins at "
            f"({left:g}, {top:g})."
        )
    most = 2 if tracking else 1
    if truncation != -1 and not 0 <= truncation <= most:
        return f"The truncation of a {name} is {truncation:g}; it is 0 to {most}, or -1 if unknown."
    if not -1 <= occlusion <= _MOST_OCCLUDED or occlusion % 1:
        return f"The occlusion of a {name} is {occlusion:g}; it is 0, 1, 2, 3, or -1 if unknown."
    largest = _LARGEST_ANGLE["result" if result else "label"]
    for kind, angle in zip(("alpha", "rotation_y"), (row[i] for i in _ANGLES), strict=True):
        if abs(angle) > largest and angle != _UNKNOWN_ANGLE:
            return (
                f"The angle {kind} of a {name} is {angle:g}; it is a number of radians from "
                f"{-largest:.2f} to {largest:.2f}, or -10 if unknown."
            )
    largest_size = LARGEST_RESULT if result else LARGEST_LABEL
    if (np.array(row[_SIZES]) > largest_size).any():
        sizes, most_sizes = (_product(each) for each in (row[_SIZES], largest_size))
        return f"A {name} measures {sizes} m (height x width x length); {most_sizes} m is the most."
    for value in row[_METRES]:
        if abs(value) > FARTHEST:
            return f"A {name} has a place or size of {value:g} m; {FARTHEST:g} m is the most."
    placed = any(value != NOWHERE for value in row[_LOCATION])
    if placed and abs(row[_HEIGHT]) > HIGHEST:
        return f"A {name} stands {row[_HEIGHT]:g} m below the camera; {HIGHEST:g} m is the most."
    return None


def _product(sizes: Sequence[float] | Floats) -> str:
    return " x ".join(f"{size:g}" for size in sizes)
