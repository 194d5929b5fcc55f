"""A scan's turn: when each ray was sent, and where the vehicle was then."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel

TIP = 0.165
"""Height above the origin of the velodyne frame from which rays leave, metres.

KITTI's sensor has two blocks of lasers, 0.2 and 0.13 m above its origin.
"""


@dataclass(frozen=True)
class RollingSweep:
    """How a scan came about: rays leave one after the other while the head turns to the left.

    The scan's own time, to which its pose belongs, is that at which the head faces ahead; behind,
    a turn begins and ends.

    Args:
        speed: Speed of the vehicle along its heading, m/s, where points lie in the frame of their
            own pulse; 0 where the vehicle's motion is compensated.
        turn_rate: How fast the vehicle turns to the left, rad/s; 0 likewise.
        period: Duration of a turn, seconds; 0 where all rays leave at once.

    Raises:
        ConfigurationError: A number that is not finite, or a negative period.
    """

    speed: float = 0.0
    turn_rate: float = 0.0
    period: float = 0.1

    def __post_init__(self) -> None:
        finite = np.isfinite([self.speed, self.turn_rate, self.period]).all()
        if not finite or not 0.0 <= self.period <= 1.0:
            raise ConfigurationError(
                "a sweep has a finite speed and turn rate and lasts 0 to 1 s, got"
                f" {self.speed}, {self.turn_rate} and {self.period}"
            )

    def compensated(self, points: NDArray[np.float32]) -> tuple[Floats, Floats]:
        """Points of a scan in the velodyne frame of the scan's own time.

        Args:
            points: Points, each in the frame of its own pulse, shape (M, 3) or (M, 4).

        Returns:
            The points, shape (M, 3), and when each was measured after the scan's time, seconds,
            shape (M,).
        """
        places, seconds = np.empty((len(points), 3)), np.empty(len(points))
        _compensate(points, self.speed, self.turn_rate, self.period, places, seconds)
        return places, seconds

    def facing_time(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """When, after the scan's time, the head faces places of its velodyne frame, seconds."""
        return np.asarray(np.arctan2(y, x) * self.period / (2.0 * np.pi))

    def rolled(self, places: Floats) -> Floats:
        """The inverse of `compensated` for things that stand: each in the frame of its own pulse.

        Args:
            places: Places in the velodyne frame of the scan's own time, shape (M, 3).

        Returns:
            Shape (M, 3).
        """
        rolled = np.empty((len(places), 3))
        _roll(np.asarray(places, np.float64), self.speed, self.turn_rate, self.period, rolled)
        return rolled


@kernel(nogil=True)
def ray_time(x: float, y: float, period: float) -> float:
    """Seconds after the scan's time at which the head faces a place of the velodyne frame."""
    return np.arctan2(y, x) * period / (2.0 * np.pi)


@kernel(nogil=True)
def to_scan_time(
    x: float, y: float, seconds: float, speed: float, turn_rate: float
) -> tuple[float, float]:
    """A place in the frame that the vehicle has so much later, in that of the scan's time."""
    cos, sin, ahead, left = _motion(seconds, speed, turn_rate)
    return cos * x - sin * y + ahead, sin * x + cos * y + left


@kernel(nogil=True)
def from_scan_time(
    x: float, y: float, seconds: float, speed: float, turn_rate: float
) -> tuple[float, float]:
    """The inverse of `to_scan_time`."""
    cos, sin, ahead, left = _motion(seconds, speed, turn_rate)
    x, y = x - ahead, y - left
    return cos * x + sin * y, cos * y - sin * x


@kernel(nogil=True)
def when_faced(
    to_sensor: Floats,
    motion: tuple[float, float, float],
    age: float,
    place: Floats,
    velocity: Floats,
) -> tuple[float, float, float, float, float, float, float]:
    """Where a moving place is when the head of a vehicle's sensor faces it, and when that is.

    Args:
        to_sensor: The transform from the world to the velodyne frame, shape (4, 4).
        motion: The vehicle's speed, turn rate, and the period of its head.
        age: Seconds from when it is at its place to the scan.
        place: The place in the world, shape (3,).
        velocity: Its velocity along the world's x and y, shape (2,).

    Returns:
        x, y and z in the sensor's frame of the time when the head faces it, and the azimuth of
        that; how long after it was at its place that is, seconds; the frame's time after the
        scan's; by how much that may be off.
    """
    speed, turn_rate, period = motion
    x, y, z, azimuth, later, time, faced = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    # When it is faced depends on where it is then: once by its place at the scan's time, once
    # more by what follows.
    for _ in range(2):
        later = age + faced
        x, y, z = through(
            to_sensor, place[0] + later * velocity[0], place[1] + later * velocity[1], place[2]
        )
        time = ray_time(x, y, period)
        x, y = from_scan_time(x, y, time, speed, turn_rate)
        azimuth = np.arctan2(y, x)
        faced = azimuth * period / (2.0 * np.pi)
    return x, y, z, azimuth, later, time, abs(faced - time)


@kernel(nogil=True)
def through(pose: Floats, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A place through a rigid transform of shape (4, 4)."""
    return (
        pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3],
        pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3],
        pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3],
    )


@kernel(nogil=True)
def _motion(seconds: float, speed: float, turn_rate: float) -> tuple[float, float, float, float]:
    """Cosine and sine of the vehicle's turn since the scan's time, and its way ahead and left."""
    # The chord of an arc points half of its angle off the heading.
    chord, half = speed * seconds, 0.5 * turn_rate * seconds
    cos, sin = np.cos(half), np.sin(half)
    if abs(half) > 1e-9:
        chord *= sin / half
    return cos * cos - sin * sin, 2.0 * sin * cos, chord * cos, chord * sin


@kernel(nogil=True)
def _roll(places: Floats, speed: float, turn_rate: float, period: float, rolled: Floats) -> None:
    for i in range(len(places)):
        x, y = places[i, 0], places[i, 1]
        # The head faces a place at a time that depends on where the place is then.
        for _ in range(4):
            seconds = ray_time(x, y, period)
            x, y = from_scan_time(places[i, 0], places[i, 1], seconds, speed, turn_rate)
        rolled[i, 0], rolled[i, 1], rolled[i, 2] = x, y, places[i, 2]


@kernel(nogil=True)
def _compensate(
    points: NDArray[np.float32],
    speed: float,
    turn_rate: float,
    period: float,
    places: Floats,
    seconds: Floats,
) -> None:
    for i in range(len(points)):
        x, y = float(points[i, 0]), float(points[i, 1])
        seconds[i] = ray_time(x, y, period)
        places[i, 0], places[i, 1] = to_scan_time(x, y, seconds[i], speed, turn_rate)
        places[i, 2] = points[i, 2]
