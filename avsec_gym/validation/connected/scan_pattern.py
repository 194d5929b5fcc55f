"""`ScanPattern`: how a LiDAR's beams lie, read off a scan, so that a fit is kept from others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Points
from avsec_gym.validation.connected.sweep import TIP

_FAR = 12.0
"""Metres: nearer returns show that a sensor's lasers do not leave from one place."""
_COLUMN = np.radians(0.25)
_BAND = np.radians([-7.0, 1.0])
_SAME_BEAM = np.radians(0.06)
"""Returns of one column whose elevations differ by less come from one beam."""
_FEWEST = 50
_SPARSER = 1.5
_LOWER = 4.0


@dataclass(frozen=True)
class ScanPattern:
    """How densely a sensor's beams lie about the horizon, and where they begin.

    Args:
        spacing: Median angle between neighbouring beams from 7 degrees below to 1 degree above the
            horizon, degrees: 0.33 for the 64 beams of KITTI's sensor, 1.33 for one of 32.
        lowest: Elevation of the lowest beam, degrees.

    Raises:
        ConfigurationError: Numbers that no sensor has.
    """

    spacing: float
    lowest: float

    def __post_init__(self) -> None:
        if not (0.01 <= self.spacing <= 20.0 and -90.0 <= self.lowest <= 45.0):
            raise ConfigurationError(f"no LiDAR has beams like {self}")

    def check(self, other: ScanPattern) -> None:
        """Check that what was fitted on this pattern holds for another.

        Raises:
            ConfigurationError: The beams of the other lie 1.5 times as far apart, or as near, or
                begin 4 degrees higher or lower.
        """
        ratio = other.spacing / self.spacing
        if not 1 / _SPARSER <= ratio <= _SPARSER or abs(other.lowest - self.lowest) > _LOWER:
            raise ConfigurationError(
                f"this was fitted on beams {self.spacing:.2f} degrees apart from"
                f" {self.lowest:.0f} degrees on, these scans have them {other.spacing:.2f} degrees"
                f" apart from {other.lowest:.0f} degrees on: fit on clean instants of this rig"
            )


def scan_pattern(points: Points) -> ScanPattern | None:
    """The pattern of a scan; None where too little came back to find it.

    Args:
        points: A scan, velodyne frame, shape (M, 4).
    """
    places = np.asarray(points[:, :3], np.float64)
    places = places[np.isfinite(places).all(axis=1)]
    flat = np.hypot(places[:, 0], places[:, 1])
    places, flat = places[flat > 1.0], flat[flat > 1.0]
    if len(places) < _FEWEST:
        return None
    elevation = np.arctan2(places[:, 2] - TIP, flat)
    azimuth = np.arctan2(places[:, 1], places[:, 0])
    # In narrow columns, gaps between returns one above the other are those between beams, but for
    # beams that did not return: hence the median.
    near_horizon = (flat > _FAR) & (elevation > _BAND[0]) & (elevation < _BAND[1])
    column = np.floor(azimuth[near_horizon] / _COLUMN).astype(np.int64)
    heights = elevation[near_horizon]
    order = np.lexsort((heights, column))
    gaps = np.diff(heights[order])[np.diff(column[order]) == 0]
    gaps = gaps[gaps > _SAME_BEAM]
    if len(gaps) < _FEWEST:
        return None
    # Single stray returns are no beam.
    return ScanPattern(
        round(float(np.degrees(np.median(gaps))), 3),
        round(float(np.degrees(np.percentile(elevation, 0.2))), 2),
    )
