"""What an attack on a driving car is: it is laid once, and lasts until it is taken down."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.pipeline import Perception
from avsec_gym.sensor_system import Sensor


class DriveAttack(ABC):
    """A kind of attack over time; a new one is a class with `act` and one of the last two methods.

    An action is a vector in [-1, 1].  It holds from the frame after it, until the next action.
    What an attack keeps up stays where it is in the world, or on the object that it was laid on,
    whatever the car does in the meantime.
    """

    action_size: int
    """Numbers of an action."""
    state_size: int
    """Numbers of `state`."""
    sensors: frozenset[Sensor] = frozenset()
    """The sensors whose data it tampers with, which only a car that reads them is harmed by; empty
    for one that changes what the car believes."""

    @abstractmethod
    def begin(self) -> None:
        """Take everything down."""

    @abstractmethod
    def act(self, action: Floats, around: Surroundings) -> float:
        """Lay, keep up or take down what an action names.

        Args:
            action: The attacker's action in [-1, 1], shape (action_size,).
            around: The truth around the car at this instant; places are named relative to it.

        Returns:
            The energy that a frame of what is up now takes, in [0, 1]; 0: nothing is up.
        """

    @abstractmethod
    def state(self, around: Surroundings) -> Floats:
        """What is up, as the attacker observes it, about [-1, 1], shape (state_size,)."""

    @property
    @abstractmethod
    def facts(self) -> dict[str, float]:
        """What `info` reports of it: always the same keys."""

    def tampered(self, frame: SensorFrame, around: Surroundings) -> SensorFrame:
        """What the sensors deliver under the attack.

        Args:
            frame: The frame without the attack.
            around: The truth around the car when it was taken.
        """
        return frame

    def believed(self, perception: Perception, around: Surroundings) -> Perception:
        """What the car believes under the attack.

        Args:
            perception: The car's perception without the attack on beliefs.
            around: The truth around it.
        """
        return perception


def object_at(around: Surroundings, ahead: float, left: float) -> int | None:
    """The id of the real object nearest to a place; None: nothing is there at all.

    Args:
        around: The truth around the car.
        ahead: Metres ahead of the car.
        left: Metres to its left.
    """
    if not len(around.actors):
        return None
    apart = around.boxes.poses[:, :2] - (ahead, left)
    return int(around.actors[np.argmin(np.hypot(*apart.T))])
