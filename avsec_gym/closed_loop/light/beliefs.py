"""What the car of a light drive believes, as the planner of `avsec/ClosedLoop-v0` reads it."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from avsec_gym.closed_loop.angles import wrapped
from avsec_gym.closed_loop.belief import Belief, belief_of
from avsec_gym.closed_loop.light.light_drive import LightDrive
from avsec_gym.closed_loop.perception import (
    BlindPerception,
    DrivePerception,
    TruthPerception,
)
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.scenario.scene import Motion


class LightPerception(Protocol):
    """The perception of one car; it may remember earlier instants of the drive."""

    def begin(self, seed: int) -> None:
        """Forget the last drive; the next one's chance follows from a seed."""

    def perceive(self, drive: LightDrive) -> Belief:
        """What the car believes at the present instant; called in the order of time."""


class LightPerceived:
    """What any perception makes of the surroundings of a light drive.

    Args:
        perception: The perception.
        motion: The planner's knowledge of motion.
    """

    def __init__(self, perception: DrivePerception, motion: Motion) -> None:
        self.perception, self.motion = perception, motion

    def begin(self, seed: int) -> None:
        """Begin the perception's next drive."""
        self.perception.begin(seed)

    def perceive(self, drive: LightDrive) -> Belief:
        """What it makes of the present instant."""
        around = drive.surroundings()
        return belief_of(self.perception.perceive(around), around, self.motion)


class LightTruth:
    """Everything that is there, as it moves: what `TruthPerception` gives, bit for bit.

    Args:
        moving: Whether the planner knows how it moves; else everything is taken to stand.
    """

    def __init__(self, moving: bool) -> None:
        self.moving = moving

    def begin(self, seed: int) -> None:
        """Do nothing: there is no chance in it."""

    def perceive(self, drive: LightDrive) -> Belief:
        """The actors that are there, without those of no extent."""
        traffic, frame = drive.place.traffic, drive.reached.frame
        there = traffic.present[frame] & (traffic.sizes > 0).all(axis=1)
        speeds = traffic.speeds[frame][there]
        return Belief(
            drive.elapsed,
            through_the_camera(drive.car, traffic.poses[frame][there]),
            traffic.sizes[there, 0],
            traffic.sizes[there, 1],
            speeds if self.moving else np.zeros(len(speeds)),
            drive.place.scene.road_type,
        )


class LightBlindness:
    """Nothing at all."""

    def begin(self, seed: int) -> None:
        """Do nothing: there is no chance in it."""

    def perceive(self, drive: LightDrive) -> Belief:
        """No objects."""
        nothing = np.zeros(0)
        return Belief(
            drive.elapsed,
            np.zeros((0, 3)),
            nothing,
            nothing,
            nothing,
            drive.place.scene.road_type,
        )


def light_perception(perception: DrivePerception, motion: Motion) -> LightPerception:
    """A perception as light drives have it: the same beliefs, bit for bit.

    Args:
        perception: The perception.
        motion: The planner's knowledge of motion.
    """
    if type(perception) is BlindPerception:
        return LightBlindness()
    if type(perception) is TruthPerception and motion != Motion.CLASSIFIER:
        return LightTruth(motion == Motion.TRUTH)
    return LightPerceived(perception, motion)


@kernel(nogil=True)
def through_the_camera(car: Floats, poses: Floats) -> Floats:
    """World poses after they were boxes in the car's camera frame: rounded as a perception's are.

    `in_world` of `camera_to_ego` of `ego_to_camera` of `seen_from`, operation by operation.

    Args:
        car: The car's state, shape (5,).
        poses: x, y, heading, shape (N, 3).
    """
    x, y, heading = car[0], car[1], car[3]
    cos, sin = np.cos(heading), np.sin(heading)
    found = np.empty_like(poses)
    for i in range(len(poses)):
        apart_x, apart_y = poses[i, 0] - x, poses[i, 1] - y
        ahead, left = cos * apart_x + sin * apart_y, cos * apart_y - sin * apart_x
        rotation_y = wrapped(-(poses[i, 2] - heading) - math.pi / 2)
        found[i, 0] = x + cos * ahead - sin * left
        found[i, 1] = y + sin * ahead + cos * left
        found[i, 2] = wrapped(-(rotation_y + math.pi / 2)) + heading
    return found
