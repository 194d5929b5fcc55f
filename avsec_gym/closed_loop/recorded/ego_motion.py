"""The recording car's motion, estimated from objects that stand.

Which objects stand follows from the motion, and the motion from objects that stand: both are found
in turns, from a first guess on (`first_guess`, `adjustment`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.recorded.adjustment import REAR_AXLE, fitted
from avsec_gym.closed_loop.recorded.first_guess import first_guess
from avsec_gym.closed_loop.recorded.recorded_traffic import (
    RecordedObject,
    RecordedTraffic,
    world_poses,
)
from avsec_gym.closed_loop.tracks import STEP
from avsec_gym.geometry import Floats

_VEHICLES = ("Car", "Van", "Truck", "Misc")
_ROUNDS = (1.5, 1.0, 0.7, 0.5, 0.5)
"""m/s up to which an object counts as standing in each round, by the median over its labels."""
_STAYS = 1.2
"""Metres between the places of an object's first and last labels up to which it stands."""
_LEAST_LABELS = 5
_ITERATIONS = (3, 3, 3, 3, 15)
"""Steps of Gauss and Newton in each round."""


@dataclass(frozen=True, eq=False)
class EgoMotion:
    """An estimate, and what it rests on.

    Args:
        poses: x, y (m), heading (rad, without jumps) of the camera at every frame, shape (T, 3).
        standing: The objects that were taken as standing.
        places: Where each of them stands: x, y, heading, shape (N, 3).
        residuals: Distance of each label's place from where its object stands, metres, by object.
        support: How many standing objects two neighbouring frames share, shape (T - 1,).
    """

    poses: Floats
    standing: tuple[RecordedObject, ...]
    places: Floats
    residuals: tuple[Floats, ...]
    support: NDArray[np.int64]

    @cached_property
    def residual(self) -> float:
        """Root mean square of all residuals, metres; nan without any."""
        whole = np.concatenate(self.residuals) if self.residuals else np.zeros(0)
        return float(np.sqrt((whole**2).mean())) if len(whole) else float("nan")


def estimate_motion(recording: RecordedTraffic) -> EgoMotion:
    """The car's motion in a recording.

    Args:
        recording: The recorded traffic; the motion that it may hold is not used.
    """
    vehicles = [
        each
        for each in recording.objects
        if each.category in _VEHICLES and len(each.frames) >= _LEAST_LABELS
    ]
    speeds, turning = first_guess(vehicles, recording.count)
    poses = _integrated(speeds, turning)
    standing: list[RecordedObject] = []
    guess = poses
    for slowest, most in zip(_ROUNDS, _ITERATIONS, strict=True):
        standing = [each for each in vehicles if stands(each, poses, slowest)]
        poses, places = fitted(poses, standing, guess, most)
    return _with_evidence(poses, standing, places)


def stands(each: RecordedObject, poses: Floats, slowest: float) -> bool:
    """Whether an object stands, as seen along a motion of the car.

    Args:
        each: The object.
        poses: The car's poses at every frame, shape (T, 3).
        slowest: m/s below which it stands.
    """
    world = world_poses(each, poses)
    time = STEP * each.frames
    half = max(len(world) // 5, 2)
    # Speed between labels that lie some way apart, so that their noise does not count.
    lag = min(8, len(world) - 1)
    way = np.hypot(*(world[lag:, :2] - world[:-lag, :2]).T)
    speed = float(np.median(way / (time[lag:] - time[:-lag])))
    ends = np.median(world[-half:, :2], axis=0) - np.median(world[:half, :2], axis=0)
    far = float(np.median(np.hypot(*each.poses[:, :2].T)))
    stays = _STAYS * slowest / _ROUNDS[-1] + 0.02 * far
    return speed < slowest and float(np.hypot(*ends)) < stays


def _integrated(speeds: Floats, turning: Floats) -> Floats:
    """Poses of the camera along speeds of the rear axle."""
    headings = np.concatenate([[0.0], np.cumsum(STEP * turning[:-1])])
    middle = headings[:-1] + 0.5 * np.diff(headings)
    way = STEP * 0.5 * (speeds[1:] + speeds[:-1])
    x = np.concatenate([[0.0], np.cumsum(way * np.cos(middle))])
    y = np.concatenate([[0.0], np.cumsum(way * np.sin(middle))])
    return np.column_stack(
        [
            x + REAR_AXLE * (np.cos(headings) - 1.0),
            y + REAR_AXLE * np.sin(headings),
            headings,
        ]
    )


def _with_evidence(poses: Floats, standing: list[RecordedObject], places: Floats) -> EgoMotion:
    residuals, support = [], np.zeros(len(poses) - 1, np.int64)
    for each, place in zip(standing, places, strict=True):
        away = np.hypot(*(world_poses(each, poses)[:, :2] - place[:2]).T)
        residuals.append(away)
        there = np.zeros(len(poses), bool)
        there[each.frames] = True
        support += there[1:] & there[:-1]
    return EgoMotion(poses, tuple(standing), places, tuple(residuals), support)
