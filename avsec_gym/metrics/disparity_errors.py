"""Errors of disparity as KITTI's stereo benchmarks count them, pooled over pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.kitti.map_files import Disparity

FAR_OFF, RELATIVELY_FAR_OFF = 3.0, 0.05
"""Pixels; share of the true disparity.  Stereo 2012 asks for the first alone, stereo 2015 (D1) for
both."""

_CONFIDENCE = (0.025, 0.975)


class Sums(NamedTuple):
    """Sums over some pixels of a pair."""

    pixels: float
    error: float
    """Sum of |found - true|, pixels."""
    off_3px: float
    """Pixels off by more than 3."""
    d1: float
    """Pixels off by more than 3 and more than 5 %."""


class Errors(NamedTuple):
    """Errors of a pair: where the estimator found something, and everywhere, its holes filled."""

    found: Sums
    all: Sums


def disparity_errors(found: Disparity, truth: Disparity) -> Errors:
    """Compare disparities with true ones.

    Args:
        found: The disparities that were found, shape (H, W), pixels, NaN where nothing was found.
        truth: The same shape, NaN where unknown.
    """
    known = np.isfinite(truth)
    full = filled(found)
    return Errors(_sums(found, truth, known & np.isfinite(found)), _sums(full, truth, known))


def filled(found: Disparity) -> Disparity:
    """Holes filled from their rows, as KITTI's development kit does before it counts all pixels.

    A hole gets the smaller of the two values at its ends (what is behind), or the one there is; a
    row without any value that of the nearest row above with one, or else below; without any value
    at all, 0.
    """
    known = np.isfinite(found)
    rows = known.any(axis=1)
    if not rows.any():
        return np.zeros_like(found)
    width = found.shape[1]
    columns = np.arange(width)
    before = np.maximum.accumulate(np.where(known, columns, -1), axis=1)
    behind = np.minimum.accumulate(np.where(known, columns, width)[:, ::-1], axis=1)[:, ::-1]
    row = np.arange(len(found))[:, None]
    infinite = np.float32(np.inf)
    left = np.where(before >= 0, found[row, np.maximum(before, 0)], infinite)
    right = np.where(behind < width, found[row, np.minimum(behind, width - 1)], infinite)
    full = np.where(known, found, np.minimum(left, right))
    nearest = np.maximum.accumulate(np.where(rows, np.arange(len(found)), -1))
    nearest[nearest < 0] = int(rows.argmax())
    return np.asarray(full[nearest], np.float32)


@dataclass(frozen=True)
class ErrorRate:
    """A rate over all pixels of all pairs; None where there is no pixel."""

    value: float | None
    interval: list[float] | None
    """Low and high of 95 %."""


@dataclass(frozen=True)
class PixelRates:
    """Rates of the pixels that are looked at."""

    end_point_error: ErrorRate
    """The mean error, pixels."""
    off_3px: ErrorRate
    """The share that is off by more than 3 pixels."""
    d1: ErrorRate
    """The share that is off by more than 5 % as well."""


@dataclass(frozen=True)
class DisparityRates:
    """How exact disparities are."""

    density: ErrorRate
    """The share of the known pixels where something was found."""
    found: PixelRates
    """What was found of these pixels."""
    all: PixelRates
    """Errors of all known pixels, holes filled."""


def error_rates(errors: Sequence[Errors], resamples: int = 0, seed: int = 0) -> DisparityRates:
    """End-point error (pixels) and shares (of 1) over all pixels of all pairs.

    Args:
        errors: The errors of each pair.
        resamples: Pairs are drawn anew so many times for 95 % intervals; 0: none.
        seed: The seed of these draws.
    """
    sums = np.array(errors, float)  # (pairs, 2, 4)
    drawn = np.random.default_rng(seed).integers(0, len(sums), (resamples, len(sums)))
    totals = np.concatenate([sums.sum(axis=0)[None], sums[drawn].sum(axis=1)])
    pixels = totals[..., 0]
    found, known = (
        PixelRates(
            *(_with_interval(_share(totals[:, part, i], pixels[:, part])) for i in (1, 2, 3))
        )
        for part in range(len(Errors._fields))
    )
    return DisparityRates(_with_interval(_share(pixels[:, 0], pixels[:, 1])), found, known)


def _sums(found: Disparity, truth: Disparity, where: np.ndarray) -> Sums:
    true = truth[where].astype(float)
    error = np.abs(found[where] - true)
    off = error > FAR_OFF
    relatively = error > RELATIVELY_FAR_OFF * true
    return Sums(len(true), float(error.sum()), float(off.sum()), float((off & relatively).sum()))


def _share(part: Floats, whole: Floats) -> Floats:
    return np.divide(part, whole, out=np.full_like(part, np.nan), where=whole > 0)


def _with_interval(values: Floats) -> ErrorRate:
    """The first value, and where 95 % of the others lie."""
    value, others = values[0], values[1:][np.isfinite(values[1:])]
    low_high = np.quantile(others, _CONFIDENCE) if len(others) else None
    return ErrorRate(
        value=None if np.isnan(value) else round(float(value), 5),
        interval=None if low_high is None else [round(float(bound), 5) for bound in low_high],
    )
