"""Where an attacker wants its bogus return, as an action."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.argument_checks import flag, number_range
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.envs.actions import LinearScale
from avsec_gym.geometry import Floats

SIZE = 4
"""Range, bearing, width, height."""

Ends = tuple[float, float]
LIMITS: dict[str, Ends] = {
    "distances": (0.1, 120.0),
    "bearings": (-np.pi, np.pi),
    "widths": (0.01, 50.0),
    "heights": (0.01, 10.0),
}
"""Metres and radians; a Velodyne HDL-64E sees no farther than 120 m."""


@dataclass(frozen=True)
class SpoofingCoding:
    """Actions in [-1, 1], scaled linearly to bogus returns.

    Args:
        distances: Distances along the ground, metres; as the next three, the smallest and the
            largest, within `LIMITS`.
        bearings: Radians to the left of ahead.
        widths: The least and the greatest width, metres.
        heights: The least and the greatest height, metres, from the road up.
        rays_lost: Whether the beams that meet the points return nothing from behind them, see
            `LidarSpoofing`.

    Raises:
        ConfigurationError: A range is none or goes beyond the limits, or a flag is no flag.
    """

    distances: Ends = (5.0, 40.0)
    bearings: Ends = (-0.7, 0.7)
    widths: Ends = (0.5, 2.5)
    heights: Ends = (0.5, 1.5)
    rays_lost: bool = False

    def __post_init__(self) -> None:
        for name, limits in LIMITS.items():
            ends = number_range(name, getattr(self, name), *limits)
            object.__setattr__(self, name, ends)
        object.__setattr__(self, "rays_lost", flag("rays_lost", self.rays_lost))

    def decode(self, action: Floats) -> LidarSpoofing:
        """The bogus return that an action names: distance, bearing, width, height; shape (4,)."""
        distance, bearing, width, height = self._scale.decode(action).tolist()
        return LidarSpoofing(width, height, distance, bearing, rays_lost=self.rays_lost)

    def encode(self, attack: LidarSpoofing) -> Floats:
        """The inverse of `decode` for one with one distance and a bearing, shape (4,)."""
        bearing = np.nan if attack.bearing is None else attack.bearing
        values = [attack.distance, bearing, attack.width, attack.height]
        return self._scale.encode(np.array(values, float))

    @property
    def largest(self) -> float:
        """Area of the largest patch, square metres."""
        return self.widths[1] * self.heights[1]

    @property
    def _scale(self) -> LinearScale:
        ends = np.array([self.distances, self.bearings, self.widths, self.heights], float)
        return LinearScale(ends[:, 0], ends[:, 1])
