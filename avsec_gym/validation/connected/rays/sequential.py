"""A test over frames: evidence that stays too small for one frame adds up over several.

`avsec connected --sequence` adds up the highest scores of successive instants by it.  The
experiment ``chapter4_drives`` adds up those of each region's track, and measures what that is
worth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.argument_checks import number, whole_number
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.roc_curve import threshold_at
from avsec_gym.metrics.tolerance import rate_bound


@dataclass(frozen=True)
class SequentialTest:
    """Page's cumulative sum: ``W_t = max(0, W_(t-1) + clip(x_t) - allowance)``, alarm at `limit`.

    The scores of a region's track, or the highest of a vehicle, go in; without one (a frame in
    which nothing was decidable: NaN, or minus infinity as of `Decision.score`) the sum stays.

    What errs at one frame errs at the next, as poses do: with a correlation ``r`` of successive
    scores, n frames inform as much as ``1 + (n - 1) (1 - r) / (1 + r)`` independent ones (the
    Fisher information of the mean of an autoregressive process).  So the frame with which a sum
    begins counts whole, and each one after it as ``(1 - r) / (1 + r)``.

    Args:
        limit: Sum from which the test alarms.
        allowance: What a frame's score must exceed for the sum to rise; no larger than `clip`.
        clip: Largest size of a frame's score: one frame alone cannot decide, if it is smaller than
            the limit.
        correlation: Correlation of the scores of successive frames, see `fitted_correlation`.

    Raises:
        ConfigurationError: A limit or clip that is not positive, an allowance beyond `clip`, or a
            correlation that is not from 0 to below 1.

    Example:
        >>> SequentialTest(limit=4.0, clip=3.0).alarm([1.5, 1.5, -np.inf, 1.5])
        3
    """

    limit: float = 5.0
    allowance: float = 0.0
    clip: float = 5.0
    correlation: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.correlation < 1:
            raise ConfigurationError(
                f"a correlation of frames is from 0 to below 1, got {self.correlation!r}"
            )
        if not (self.limit > 0 and self.clip > 0 and abs(self.allowance) <= self.clip):
            raise ConfigurationError(
                "a sequential test has a positive limit and clip, and an allowance between -clip "
                f"and clip, got {self}"
            )

    def sums(self, scores: ArrayLike) -> Floats:
        """The sum after each frame, shape (T,).

        Args:
            scores: Score of each frame, NaN or minus infinity without one, shape (T,).
        """
        given = np.asarray(scores, np.float64)
        none = np.isnan(given) | np.isneginf(given)
        steps = np.where(none, self.allowance, np.clip(given, -self.clip, self.clip))
        further = (1.0 - self.correlation) / (1.0 + self.correlation)
        result = np.zeros(len(steps))
        total = 0.0
        for frame, step in enumerate(steps):
            weight = further if total > 0 else 1.0
            total = max(0.0, total + weight * (float(step) - self.allowance))
            result[frame] = total
        return result

    def alarm(self, scores: ArrayLike) -> int | None:
        """The first frame of an alarm, or None."""
        over = np.flatnonzero(self.sums(scores) >= self.limit)
        return int(over[0]) if len(over) else None


def windows(scores: Sequence[float] | Floats, frames: int) -> list[Floats]:
    """The windows of so many successive frames that do not overlap; a rest is left out."""
    whole = np.asarray(scores, np.float64)
    return [whole[i : i + frames] for i in range(0, len(whole) - frames + 1, frames)]


def fitted_correlation(attack_free: Sequence[Floats], clip: float = 5.0) -> float:
    """The correlation of the scores of successive frames, for `SequentialTest`.

    Args:
        attack_free: Scores of each frame of tracks without an attack, NaN or minus infinity without
            one.
        clip: Largest size of a frame's score, as of `SequentialTest`.

    Returns:
        From 0 to below 1; 0 where no two successive frames have scores, or all are the same.

    Example:
        >>> tracks = [np.array([1.0, 1.0, -1.0, -1.0]), np.array([1.0, -np.inf, 1.0])]
        >>> round(fitted_correlation(tracks), 3)
        0.333
    """
    pairs = [np.zeros((0, 2))]
    for scores in attack_free:
        known = np.where(np.isneginf(scores), np.nan, np.clip(scores, -clip, clip))
        pairs.append(np.stack([known[:-1], known[1:]], axis=1))
    every = np.concatenate(pairs)
    every = every[np.isfinite(every).all(axis=1)]
    if not len(every):
        return 0.0
    away = every - every.mean()
    spread = float((away**2).mean())
    found = float((away[:, 0] * away[:, 1]).mean()) / spread if spread > 0 else 0.0
    return min(max(found, 0.0), _MOST_ALIKE)


_MOST_ALIKE = 0.99


def share_of_alarms(test: SequentialTest, scores: Sequence[Floats], drives: Sequence[str]) -> Share:
    """How many windows alarm.

    Args:
        test: The test.
        scores: Scores of each frame of the windows.
        drives: The drive of each window: windows of one drive are no independent cases, since
            errors of poses last for seconds.
    """
    return share_of([test.alarm(window) is not None for window in scores], drives)


def bound_on_false_alarms(
    test: SequentialTest, attack_free: Sequence[Floats], drives: Sequence[str]
) -> float:
    """The share of attack-free drives that alarm at most, with 95 % confidence.

    A drive counts once, and alarms where one of its windows does: the bound holds however alike
    the windows of a drive are (`rate_bound`).

    Args:
        test: The test, which was fitted on other drives.
        attack_free: Scores of each frame of windows without an attack.
        drives: The drive of each window.

    Raises:
        ConfigurationError: No windows.
    """
    loud = {
        drive
        for drive, scores in zip(drives, attack_free, strict=True)
        if test.alarm(scores) is not None
    }
    return rate_bound(len(set(drives)), len(loud))


def lasting_test(attack_free: Sequence[float], frames: int, rate: float) -> SequentialTest:
    """A test over windows, from scores of single attack-free frames, each of a drive of its own.

    How alike successive frames are is not known from single ones.  The limit is that of the case in
    which a window has the score of its first frame throughout: then as many windows alarm as single
    frames would.  A frame counts as two at most of the score that may just not alarm.

    Args:
        attack_free: Highest score of each attack-free frame; minus infinity where there is none.
        frames: Number of frames of a window.
        rate: Share of windows that may alarm.

    Raises:
        ConfigurationError: Fewer than two frames, or no such share.
        DataError: No scores.
    """
    frames, rate = whole_number("frames", frames, 2), number("rate", rate, 0.0, 1.0)
    if not len(attack_free):
        raise DataError("A sequential test is fitted on attack-free frames.")
    # What speaks against an attack, or hardly for one, never adds up to an alarm.
    highest = max(threshold_at(np.asarray(attack_free, np.float64), rate), _LEAST_SCORE)
    return SequentialTest(float(np.nextafter(frames * highest, np.inf)), clip=2 * highest)


_LEAST_SCORE = 0.5
"""The least score that a limit is fitted to, nats."""


def fit_limit(
    attack_free: Sequence[Floats], rate: float, allowance: float = 0.0, clip: float = 5.0
) -> SequentialTest:
    """The test with the smallest limit at which at most a share of attack-free windows alarms.

    Args:
        attack_free: Scores of each frame of windows without an attack.
        rate: Share of windows that may alarm.
        allowance: What a score must exceed for the sum to rise, see `SequentialTest`.
        clip: Largest size of a frame's score, see `SequentialTest`.

    Raises:
        DataError: No windows.
    """
    if not attack_free:
        raise DataError("A sequential test is fitted on windows without an attack.")
    sums = SequentialTest(allowance=allowance, clip=clip).sums
    highest = np.sort([sums(scores).max(initial=0.0) for scores in attack_free])[::-1]
    # The sums of the windows that may alarm lie at or above the limit, the next one below it.
    next_one = float(highest[min(int(rate * len(highest)), len(highest) - 1)])
    return SequentialTest(float(np.nextafter(max(next_one, 1e-6), np.inf)), allowance, clip)
