"""What connected vehicles share of an instant, beside the frame of one of them (chapter 4).

A frame that has them (`SensorFrame.connected`) can be judged by what the others scan.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats


@dataclass(frozen=True, eq=False)
class ScanPose:
    """Where and how a scan was taken, as the one who took it measures that.

    Args:
        pose: The transform from the velodyne frame to the world that all share, shape (4, 4).
        time: The time of the scan after the instant, seconds.
        speed: Speed along the heading while the head turned, m/s; 0 where motion is compensated.
        turn_rate: How fast the vehicle turned to the left, rad/s; 0 likewise.
        period: Duration of a turn, seconds; 0 where all rays left at once.
        roadside: Whether it is a fixed LiDAR beside the road.
    """

    pose: Floats
    time: float = 0.0
    speed: float = 0.0
    turn_rate: float = 0.0
    period: float = 0.0
    roadside: bool = False


@dataclass(frozen=True, eq=False)
class SharedScan:
    """The scan of another one.

    Args:
        points: The points, velodyne frame, with reflectance, shape (M, 4); or what loads them.
        place: Where and how it was taken.
    """

    points: NDArray[np.float32] | Callable[[], NDArray[np.float32]]
    place: ScanPose


@dataclass(frozen=True, eq=False)
class ConnectedScans:
    """What all others scanned at a vehicle's instant, and where its own scan was taken.

    Args:
        own: The pose of the vehicle's own scan, which is that of its frame.
        others: The scans of the others, one or more.
    """

    own: ScanPose
    others: tuple[SharedScan, ...]
