"""A LiDAR scan of one of several connected vehicles, with the pose that aligns it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.validation.connected.sweep import RollingSweep


@dataclass(frozen=True, eq=False)
class VehicleScan:
    """What one vehicle knows of itself at an instant.

    Args:
        points: The vehicle's scan, velodyne frame, metres, with reflectance, shape (M, 4).
        pose: The rigid transform ``Tr = (R, t)`` from the velodyne frame to the world that all
            vehicles share, as the vehicle measures it, shape (4, 4).
        time: The time of the scan after the instant, seconds.
        sweep: How the scan came about, by the vehicle's own odometry.
        roadside: Whether it is of a fixed LiDAR beside the road: no vehicle's body stands about it.

    Raises:
        DataError: The pose is no rigid transform of finite numbers, or the points are not (M, 4).

    Example:
        >>> VehicleScan(np.ones((2, 4), np.float32), np.eye(4)).in_world().shape
        (2, 3)
    """

    points: NDArray[np.float32]
    pose: Floats
    time: float = 0.0
    sweep: RollingSweep = field(default_factory=RollingSweep)
    roadside: bool = False

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 4:
            raise DataError(f"a scan has the shape (M, 4), not {self.points.shape}")
        rotation = np.asarray(self.pose, np.float64)[:3, :3]
        rigid = (
            self.pose.shape == (4, 4)
            and bool(np.isfinite(self.pose).all())
            and np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-3)
        )
        if not rigid or not np.isfinite(self.time):
            raise DataError("a pose is a rigid transform of shape (4, 4), its time a number")

    def in_world(self) -> Floats:
        """The points in the world, as the vehicle saw it at the scan's own time, shape (M, 3)."""
        return transform_points(self.pose, self.compensated().points[:, :3])

    def compensated(self) -> VehicleScan:
        """The scan with its points where they would be, had all rays left at the scan's time."""
        return self._compensated

    @cached_property
    def _compensated(self) -> VehicleScan:
        if self.sweep.speed == 0.0 and self.sweep.turn_rate == 0.0:
            return self
        places, _ = self.sweep.compensated(self.points)
        points = np.c_[places, self.points[:, 3]].astype(np.float32)
        return replace(self, points=points, sweep=RollingSweep(period=self.sweep.period))

    def with_points(self, points: NDArray[np.float32]) -> VehicleScan:
        """The same scan of other points, such as tampered ones."""
        return replace(self, points=points)
