"""A first guess of a car's speed and turn rate, from how labelled vehicles move around it.

A standing object at (x, y) in the frame of a car that drives at v and turns at w moves by
``(-v + w y, -w x)`` and turns by ``-w``.  Vehicles do not reverse: one that heads as the car does
bounds v from below, one that heads against it from above; one that stands across is exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from avsec_gym.closed_loop.recorded.recorded_traffic import RecordedObject
from avsec_gym.closed_loop.tracks import STEP
from avsec_gym.geometry import Floats

_HALF = 4
"""Frames before and after one over which its velocities are measured."""
_LEAST = 4
"""Labels in these frames that a velocity needs."""
_SPEEDS = np.arange(-1.0, 30.0, 0.1)
"""Speeds that the car may have, m/s."""
_SPREAD = 0.5
"""m/s by which the speeds differ that standing objects speak for."""
_ACCELERATION = 2.5
"""m/s2, the standard deviation of the car's."""
_REVERSING = 3.0
"""What a vehicle that would reverse counts against a speed."""
_NOTHING = 0.05
"""Weight of a speed that no object speaks for."""


@dataclass(frozen=True, eq=False)
class Velocities:
    """How objects move in the car's frame, a row for each object and frame.

    Args:
        frames: Frame of each, shape (n,).
        poses: x, y, heading, shape (n, 3).
        rates: The rates of change of each pose, m/s and rad/s, shape (n, 3).
    """

    frames: np.ndarray[tuple[int], np.dtype[np.int64]]
    poses: Floats
    rates: Floats


def velocities(objects: list[RecordedObject]) -> Velocities:
    """Slopes of straight lines through the labels around each label.

    Args:
        objects: The objects.
    """
    frames, poses, rates = [], [], []
    for each in objects:
        for row, frame in enumerate(each.frames.tolist()):
            near = np.abs(each.frames - frame) <= _HALF
            if near.sum() < _LEAST:
                continue
            time = STEP * (each.frames[near] - frame)
            centred = time - time.mean()
            slope = centred @ each.poses[near] / (centred @ centred)
            frames.append(frame)
            poses.append(each.poses[row])
            rates.append(slope)
    return Velocities(
        np.array(frames, np.int64), np.array(poses).reshape(-1, 3), np.array(rates).reshape(-1, 3)
    )


def first_guess(objects: list[RecordedObject], count: int) -> tuple[Floats, Floats]:
    """Speed (m/s) and turn rate (rad/s, to the left) of the car at every frame.

    Args:
        objects: Vehicles, standing or not.
        count: Number of frames.
    """
    seen = velocities(objects)
    turning = _turn_rates(seen, count)
    return _speeds(seen, turning, count), turning


def _turn_rates(seen: Velocities, count: int) -> Floats:
    """The median of how objects turn; most vehicles do not turn themselves."""
    known = np.unique(seen.frames)
    if not len(known):
        return np.zeros(count)
    medians = [-np.median(seen.rates[seen.frames == frame, 2]) for frame in known]
    rates = np.interp(np.arange(count), known, medians)
    return np.asarray(median_filter(rates, 5, mode="nearest"))


def _speeds(seen: Velocities, turning: Floats, count: int) -> Floats:
    """The likeliest course of the speed, without sudden changes (Viterbi)."""
    evidence = np.full((count, len(_SPEEDS)), np.log(_NOTHING))
    for frame in np.unique(seen.frames).tolist():
        here = seen.frames == frame
        evidence[frame] = _evidence(seen.poses[here], seen.rates[here], turning[frame])
    # Changes of speed from frame to frame, within four standard deviations.
    reach = round(4 * _ACCELERATION * STEP / (_SPEEDS[1] - _SPEEDS[0]))
    changes = np.arange(-reach, reach + 1)
    price = 0.5 * (changes * (_SPEEDS[1] - _SPEEDS[0]) / (_ACCELERATION * STEP)) ** 2
    score, before = evidence[0], np.zeros((count, len(_SPEEDS)), np.int64)
    for frame in range(1, count):
        padded = np.pad(score, reach, constant_values=-np.inf)
        options = np.lib.stride_tricks.sliding_window_view(padded, len(changes)) - price
        best = options.argmax(axis=1)
        before[frame] = np.arange(len(_SPEEDS)) + changes[best]
        score = options[np.arange(len(_SPEEDS)), best] + evidence[frame]
    path = np.zeros(count, np.int64)
    path[-1] = int(score.argmax())
    for frame in range(count - 1, 0, -1):
        path[frame - 1] = before[frame, path[frame]]
    return np.asarray(_SPEEDS[path])


def _evidence(poses: Floats, rates: Floats, turning: float) -> Floats:
    """Log-weights of all speeds, of the objects of one frame."""
    x, y, heading = poses.T
    along = -rates[:, 0] + turning * y
    aside = rates[:, 1] + turning * x
    # One that moves across the car's way does not stand; what is far is less sure.
    share = np.exp(-0.5 * (aside / (0.7 + 0.03 * np.abs(x))) ** 2) / (1.0 + (np.abs(x) / 40.0) ** 2)
    apart = _SPEEDS - along[:, None]
    votes = (share[:, None] * np.exp(-0.5 * (apart / _SPREAD) ** 2)).sum(axis=0)
    # Own speed of each along its heading, if the car's were that.
    own = apart * np.cos(heading)[:, None]
    certain = np.abs(np.cos(heading))[:, None] > 0.5
    reversing = (certain * np.clip(-own - 1.0, 0.0, 1.0)).sum(axis=0)
    return np.asarray(np.log(_NOTHING + votes) - _REVERSING * reversing)
