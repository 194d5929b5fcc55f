"""`Observer`: a vehicle at an instant with its rays at hand, which claims and bears witness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.range_image import RangeImage, range_image
from avsec_gym.validation.connected.vehicle_scan import VehicleScan


@dataclass(frozen=True, eq=False)
class Observer:
    """A vehicle's scan at an instant, its rays sorted by direction.

    Args:
        scan: The scan, with the pose and time that the vehicle measures.
        image: The scan's rays.
    """

    scan: VehicleScan
    image: RangeImage

    @property
    def pose(self) -> Floats:
        """The transform from the velodyne frame to the world, shape (4, 4)."""
        return np.asarray(self.scan.pose, np.float64)

    @property
    def motion(self) -> tuple[float, float, float]:
        """Speed, turn rate and period of the sweep, as kernels take them."""
        sweep = self.scan.sweep
        return sweep.speed, sweep.turn_rate, sweep.period


def observe(scan: VehicleScan) -> Observer:
    """Sort the rays of a scan, once for all claims."""
    return Observer(scan, range_image(scan.points, scan.compensated().points))
