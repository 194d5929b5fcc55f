"""What a spoofing laser can place in a scan, as the literature measured it.

An attacker sends pulses of his own while the victim's head turns past him.  What he places lies in
the directions from which the sensor takes light of his laser: a sector of azimuth around it, in
which he chooses distances.  How many points he gets in has grown with the electronics:

- Cao et al. (CCS 2019, "Adversarial Sensor Attack on LiDAR-based Perception in Autonomous Driving")
  place about 60 points reliably in the scan of a VLP-16, in a sector of 8 degrees.
- Sun et al. (USENIX Security 2020, "Towards Robust LiDAR-based Perception in Autonomous Driving")
  grant their attacker 200 points at most, in a sector of 10 degrees.
- Sato et al. (NDSS 2024, "LiDAR Spoofing Meets the New-Gen") place thousands of points in the
  scans of first-generation sensors, more than the ghosts here have: the case without a limit.
  Newer sensors that vary the timing of their pulses withstand such placing better.

What they were measured on are other sensors than a data set's.  The reach of a laser depends on
its optics and on aiming at a moving car: it is not limited here, but by `PastedObject.distance`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from avsec_gym.frame import Points
from avsec_gym.geometry import Floats


@dataclass(frozen=True)
class SpoofingLaser:
    """What one laser can place in a turn of the victim's head.

    Args:
        points: The most points.
        sector: Width of the sector of azimuth that they lie in, degrees.
    """

    points: int
    sector: float

    def placeable(self, points: Points) -> Points:
        """A ghost's points that the laser can place, in their order.

        The laser aims at the sector with the most of them; too many are thinned evenly, by azimuth.

        Args:
            points: The ghost's points, velodyne frame, metres, reflectance, shape (M, 4).

        Returns:
            Shape (K, 4), K <= min(M, points of the laser).
        """
        azimuth = _unwrapped(np.arctan2(points[:, 1], points[:, 0]).astype(np.float64))
        order = np.argsort(azimuth, kind="stable")
        ends = np.searchsorted(azimuth[order], azimuth[order] + np.radians(self.sector), "right")
        held = ends - np.arange(len(order))
        start = int(held.argmax()) if len(held) else 0
        inside = order[start : start + int(held.max(initial=0))]
        number = min(len(inside), self.points)
        chosen = np.linspace(0, max(len(inside) - 1, 0), number).round().astype(np.int64)
        return points[np.sort(inside[chosen])]


LASERS: Mapping[str, SpoofingLaser] = {
    "cao_2019": SpoofingLaser(60, 8.0),
    "sun_2020": SpoofingLaser(200, 10.0),
}
"""Lasers by the paper that names their limits; see above."""


def _unwrapped(azimuth: Floats) -> Floats:
    """Azimuths of a thing without the jump behind the victim, radians, shape (M,)."""
    middle = np.arctan2(np.sin(azimuth).sum(), np.cos(azimuth).sum())
    return np.asarray((azimuth - middle + np.pi) % (2 * np.pi) - np.pi)
