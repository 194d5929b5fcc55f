"""Windows of a recording in which the car's motion is known well enough to drive in.

An estimate rests on objects that are taken as standing.  Objects that drive alike could be mistaken
for standing ones; a window therefore counts only where standing objects pin the speed from both
sides: one that heads as the car does bounds it from below, since vehicles do not reverse, one that
heads against it from above, one that stands across does both.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.recorded.ego_motion import EgoMotion, estimate_motion
from avsec_gym.closed_loop.recorded.recorded_traffic import RecordedObject, RecordedTraffic
from avsec_gym.closed_loop.tracks import STEP
from avsec_gym.geometry import Floats

LENGTH = 80
"""Frames of a window after its first: 8 s."""
SLOWEST, FASTEST = 4.0, 25.0
"""m/s: what a car drives at the start at least, and anywhere at most."""
TIGHTEST = 15.0
"""Metres of radius below which a bend is a turn at a junction, for which a corridor is no road."""
_GAP = 10
"""Frames that the first guess may bridge where no standing object is seen."""
_FEWEST = 3
"""Standing objects that a window needs."""
_LEAST_LABELS = 5
_LARGEST_RESIDUAL = 0.25
"""Metres, root mean square."""
_SMOOTHED = 5
"""Frames over which speeds and bends are averaged."""


class Refusal(StrEnum):
    """Why a window is not driven in."""

    SHORT = "the recording is too short"
    GAP = "no standing object for over a second"
    FEW = f"fewer than {_FEWEST} standing objects"
    ONE_SIDED = "standing objects do not pin the speed from both sides"
    RESIDUAL = f"labels are off by more than {_LARGEST_RESIDUAL} m"
    FAST = f"faster than {FASTEST:.0f} m/s"
    SLOW = f"slower than {SLOWEST:.0f} m/s at the start"
    TURN = f"a turn of less than {TIGHTEST:.0f} m radius"


@dataclass(frozen=True, eq=False)
class KnownMotion:
    """A recording and its car's motion.

    Args:
        recording: The recording.
        poses: The car's poses at every frame, shape (T, 3).
        estimate: What they were estimated from; None: they were recorded.
    """

    recording: RecordedTraffic
    poses: Floats
    estimate: EgoMotion | None

    @cached_property
    def speeds(self) -> Floats:
        """m/s from each frame to the next, averaged over half a second, shape (T - 1,)."""
        return _averaged(np.hypot(*np.diff(self.poses[:, :2], axis=0).T)) / STEP

    @cached_property
    def bends(self) -> Floats:
        """1 / m of the path, without sign, shape (T - 1,)."""
        turned = np.abs(_averaged(np.diff(self.poses[:, 2])))
        return np.asarray(turned / np.maximum(self.speeds * STEP, 0.05))

    def refusal(self, first: int) -> Refusal | None:
        """Why the window from a frame on is not driven in; None: it is.

        Args:
            first: The first frame.
        """
        if first + LENGTH >= self.recording.count:
            return Refusal.SHORT
        unknown = None if self.estimate is None else unproven(self.estimate, first, first + LENGTH)
        if unknown is not None:
            return unknown
        inside = slice(first, first + LENGTH)
        if self.speeds[inside].max() > FASTEST:
            return Refusal.FAST
        if self.speeds[first] < SLOWEST:
            return Refusal.SLOW
        if self.bends[inside].max() > 1.0 / TIGHTEST:
            return Refusal.TURN
        return None

    def starts(self, every: float) -> tuple[list[int], Counter[Refusal]]:
        """First frames of the windows to drive in, and why others are refused.

        Args:
            every: Seconds from one start to the next.
        """
        good, refused = [], Counter[Refusal]()
        step = max(round(every / STEP), 1)
        for first in range(0, max(self.recording.count - LENGTH, 1), step):
            refusal = self.refusal(first)
            if refusal is None:
                good.append(first)
            else:
                refused[refusal] += 1
        return good, refused


def known_motion(recording: RecordedTraffic) -> KnownMotion:
    """A recording's motion, as it was recorded or else estimated."""
    if recording.motion is not None:
        return KnownMotion(recording, recording.motion, None)
    if recording.count <= LENGTH:  # Too short for any window, whatever the motion.
        return KnownMotion(recording, np.zeros((recording.count, 3)), None)
    estimate = estimate_motion(recording)
    return KnownMotion(recording, estimate.poses, estimate)


def unproven(estimate: EgoMotion, first: int, last: int) -> Refusal | None:
    """What an estimate lacks between two frames; None: nothing."""
    if longest_gap(estimate.support[first:last] > 0) > _GAP:
        return Refusal.GAP
    inside = [(each.frames >= first) & (each.frames <= last) for each in estimate.standing]
    used = [i for i, labels in enumerate(inside) if labels.sum() >= _LEAST_LABELS]
    if len(used) < _FEWEST:
        return Refusal.FEW
    if not pinned([estimate.standing[i] for i in used]):
        return Refusal.ONE_SIDED
    residuals = np.concatenate([estimate.residuals[i][inside[i]] for i in used])
    if np.sqrt((residuals**2).mean()) > _LARGEST_RESIDUAL:
        return Refusal.RESIDUAL
    return None


def pinned(standing: list[RecordedObject]) -> bool:
    """Whether objects that are taken as standing leave one speed of the car only."""
    cosines = np.array([np.cos(np.median(each.poses[:, 2])) for each in standing])
    along, against = (cosines > 0.5).any(), (cosines < -0.5).any()
    return bool((along and against) or (np.abs(cosines) < 0.5).any())


def longest_gap(there: NDArray[np.bool_]) -> int:
    """The largest number of false values in a row."""
    at = np.flatnonzero(np.concatenate([[True], there, [True]]))
    return int(np.diff(at).max()) - 1


def _averaged(values: Floats) -> Floats:
    """A moving average that is shorter at the ends."""
    ones = np.ones(min(_SMOOTHED, len(values)))
    return np.asarray(
        np.convolve(values, ones, "same") / np.convolve(np.ones(len(values)), ones, "same")
    )
