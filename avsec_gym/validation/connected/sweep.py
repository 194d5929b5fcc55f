"""A scan's turn: when each ray was sent, and where the vehicle was then."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
    """From the frame that the vehicle has so much later to that at the scan's time."""
    angle = turn_rate * seconds
    # The chord of an arc points half of its angle off the heading.
    chord, half = speed * seconds, 0.5 * angle
    if abs(half) > 1e-9:
        chord *= np.sin(half) / half
    cos, sin = np.cos(angle), np.sin(angle)
    ahead, left = chord * np.cos(half), chord * np.sin(half)
    return cos * x - sin * y + ahead, sin * x + cos * y + left


@kernel(nogil=True)
def from_scan_time(
    x: float, y: float, seconds: float, speed: float, turn_rate: float
) -> tuple[float, float]:
    """The inverse of `to_scan_time`."""
    ahead, left = to_scan_time(0.0, 0.0, seconds, speed, turn_rate)
    angle = turn_rate * seconds
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = x - ahead, y - left
    return cos * x + sin * y, cos * y - sin * x


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
