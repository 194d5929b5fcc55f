"""A facula that tracks: a laser on a real object, which blinds a camera to it."""

from __future__ import annotations

import numpy as np

from avsec_gym.argument_checks import number, number_range
from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.object_injection import GhostRange
from avsec_gym.closed_loop.attack.drive_attack import DriveAttack, object_at
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, project

_NUMBERS = 5
_FARTHEST = 50.0
_LEAST_DEPTH = 1.0
"""Metres in front of the camera from which on light meets its lens."""


class TrackingFacula(DriveAttack):
    """A laser that a real object carries, and that follows one camera of the car.

    An action has five numbers: above 0, the laser is on; above 0, it shines into the right camera,
    else into the left one; the object that carries it is the one nearest to a place ahead and left;
    the radius of the spot.  The laser stays on its object as long as it is on; camera and radius
    may change.  All is scaled linearly.  The energy of a frame is the spot's area, as a share of
    the largest.

    Args:
        ahead: Metres ahead of the car, the first and the last, from 5 to 100.
        left: Metres to its left, the first and the last, within 20.
        radii: Pixels of an image 1242 wide, the smallest and the largest, from 0.1 to 10,000.
        strength: Peak of the light, grey levels, from 0.1 to 2550.

    Raises:
        ConfigurationError: A number is out of range.
    """

    action_size, state_size, sensors = _NUMBERS, 5, frozenset({LEFT, RIGHT})

    def __init__(
        self,
        ahead: tuple[float, float] = (5.0, 45.0),
        left: tuple[float, float] = (-8.0, 8.0),
        radii: tuple[float, float] = (37.5, 375.0),
        strength: float = 255.0,
    ) -> None:
        self._range = GhostRange(
            x=number_range("ahead", ahead, 5.0, 100.0), y=number_range("left", left, -20.0, 20.0)
        )
        self.radii = number_range("radii", radii, 0.1, 10_000.0)
        self.strength = number("strength", strength, 0.1, 2550.0)
        self.begin()

    def begin(self) -> None:
        """The laser is off."""
        self._carrier: int | None = None
        self._camera, self._radius = LEFT, 0.0

    def act(self, action: Floats, around: Surroundings) -> float:
        """Switch the laser on or off, choose its camera and its radius."""
        on, camera, ahead, left, radius = action.tolist()
        if on <= 0:
            self.begin()
            return 0.0
        if self._carrier is None:
            [(x, y, _)] = self._range.decode(np.array([[on, ahead, left, 0.0]]))[1].tolist()
            self._carrier = object_at(around, x, y)
        if self._carrier is None:
            return 0.0
        low, high = self.radii
        self._camera = RIGHT if camera > 0 else LEFT
        self._radius = low + 0.5 * (radius + 1.0) * (high - low)
        return (self._radius / high) ** 2

    def state(self, around: Surroundings) -> Floats:
        """On; ahead and left / 50 m of the object that carries it; right camera; radius / largest.

        Zeros where it is off.
        """
        there = around.actors == self._carrier
        if self._carrier is None or not there.any():
            return np.zeros(self.state_size)
        place = around.boxes.poses[there][0, :2] / _FARTHEST
        return np.array([1.0, *place, self._camera == RIGHT, self._radius / self.radii[1]])

    @property
    def facts(self) -> dict[str, float]:
        """The `camera` that is shone into, -1 for none, and the `radius` of the spot, pixels."""
        on = self._carrier is not None
        return {"camera": self._camera if on else -1, "radius": self._radius}

    def tampered(self, frame: SensorFrame, around: Surroundings) -> SensorFrame:
        """The frame with the spot where the camera sees the object's middle."""
        there = around.actors == self._carrier
        if self._carrier is None or not there.any():
            return frame
        box = around.boxes[there]
        middle = box.location[0] - (0.0, 0.5 * box.dimensions[0, 0], 0.0)
        pixel, depth = project(frame.calibration.projection(self._camera), middle)
        if depth < _LEAST_DEPTH:
            return frame
        centre = float(pixel[0]), float(pixel[1])
        return Facula(self._camera, self._radius, centre, self.strength).attack(frame).frame
