"""What the car of a light drive believes: the truth, nothing, or the truth with drawn errors."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.light.light_drive import LightDrive
from avsec_gym.geometry import Floats


class Believed(NamedTuple):
    """N believed objects in the world frame."""

    poses: Floats
    """x, y, heading, shape (N, 3)."""
    lengths: Floats
    """Metres, shape (N,)."""
    widths: Floats
    """Metres, shape (N,)."""
    speeds: Floats
    """Speeds along the headings that the planner reckons with, m/s, shape (N,)."""


class LightPerception(Protocol):
    """The perception of one car; it may remember earlier instants of the drive."""

    def begin(self, seed: int) -> None:
        """Forget the last drive; the next one's chance follows from a seed."""

    def perceive(self, drive: LightDrive) -> Believed:
        """What the car believes at the present instant; called in the order of time."""


class LightTruth:
    """Everything that is there, as it moves.

    Args:
        moving: Whether the planner knows how it moves; else everything is taken to stand.
    """

    def __init__(self, moving: bool) -> None:
        self.moving = moving

    def begin(self, seed: int) -> None:
        """Do nothing: there is no chance in it."""

    def perceive(self, drive: LightDrive) -> Believed:
        """The actors that are there, without those of no extent."""
        traffic, frame = drive.place.traffic, drive.reached.frame
        there = traffic.present[frame] & (traffic.sizes > 0).all(axis=1)
        speeds = traffic.speeds[frame][there]
        return Believed(
            traffic.poses[frame][there],
            traffic.sizes[there, 0],
            traffic.sizes[there, 1],
            speeds if self.moving else np.zeros(len(speeds)),
        )


class LightBlindness:
    """Nothing at all."""

    def begin(self, seed: int) -> None:
        """Do nothing: there is no chance in it."""

    def perceive(self, drive: LightDrive) -> Believed:
        """No objects."""
        return Believed(np.zeros((0, 3)), np.zeros(0), np.zeros(0), np.zeros(0))


def belief_of_light(drive: LightDrive, believed: Believed) -> Belief:
    """The same as a planner reads it.

    Args:
        drive: The drive; the belief is of its present instant.
        believed: What the car believes.
    """
    return Belief(drive.elapsed, *believed, road_type=drive.place.scene.road_type)
