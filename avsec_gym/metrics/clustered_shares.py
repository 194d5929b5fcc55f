"""Shares of cases, with intervals that know which cases belong together.

Moments of one drive are alike, and so are the attacks on one moment: a hundred cases may say no
more than ten.  So Wilson's interval is widened by the design effect (Kish 1965): how many times as
much the share varies from drive to drive as it would if all cases were independent.  To bootstrap
over drives asks the same, but cannot doubt what all drives have in common: where every case is a
hit, its interval is a point.  Here the spread is taken as if two more drives had been seen, one all
hits and one none: where every case is a hit, the cases count as many as the drives.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.metrics.intervals import wilson_interval

_Z95 = NormalDist().inv_cdf(0.975)


def share_of(hits: ArrayLike, drives: Sequence[str]) -> dict[str, Any]:
    """How many of how many, with a 95 % interval.

    Args:
        hits: Shape (N,), or (N, C) where a row holds all C cases of a moment.
        drives: Which drive each row is of.

    Returns:
        ``count``, ``of``, ``rate`` and ``interval``; the last two None without a case.

    Example:
        >>> share = share_of([True] * 40, ["first", "second"] * 20)
        >>> [round(bound, 3) for bound in share["interval"]]  # Two drives say little.
        [0.342, 1.0]
    """
    if not np.size(hits):
        return {"count": 0, "of": 0, "rate": None, "interval": None}
    flags = np.asarray(hits, bool).reshape(len(drives), -1)
    count, of = int(flags.sum()), int(flags.size)
    interval = wilson_interval(count, of, _Z95 * math.sqrt(_design_effect(flags, drives)))
    return {"count": count, "of": of, "rate": count / of, "interval": list(interval)}


def drive_of(moment: str) -> str:
    """The drive that a moment of `Recordings` belongs to; empty where there is one drive only.

    Example:
        >>> drive_of("2026_01_01_drive_0001_sync/0000000000"), drive_of("0000000007")
        ('2026_01_01_drive_0001_sync', '')
    """
    return moment.rpartition("/")[0]


def _design_effect(flags: NDArray[np.bool_], drives: Sequence[str]) -> float:
    """1 or more: of independent cases, and of as many cases as there are drives at most."""
    _, drive = np.unique(np.asarray(drives), return_inverse=True)
    cases = np.bincount(drive) * float(flags.shape[1])
    hits = np.bincount(drive, flags.sum(axis=1))
    usual = cases.mean()
    cases, hits = np.r_[cases, usual, usual], np.r_[hits, usual, 0.0]
    rate = hits.sum() / cases.sum()
    between = float(((hits - rate * cases) ** 2).sum())
    return max(1.0, between / float(rate * (1 - rate) * cases.sum()))
