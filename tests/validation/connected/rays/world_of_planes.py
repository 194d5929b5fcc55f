"""A world of upright boxes on flat ground, scanned by plain loops over rays: the tests' judge."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.sweep import TIP, RollingSweep
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

Box = tuple[float, float, float, float, float, float]
"""Least and greatest x, y and z in the world, metres."""
HEIGHT = 1.73
"""Height of a velodyne frame above the ground, metres."""


def pose_at(x: float, y: float, heading: float = 0.0) -> Floats:
    """The pose of a velodyne on flat ground at height 0."""
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array([[cos, -sin, 0, x], [sin, cos, 0, y], [0, 0, 1, HEIGHT], [0, 0, 0, 1]], float)


def scan_of(
    boxes: Sequence[Box],
    pose: Floats,
    *,
    time: float = 0.0,
    sweep: RollingSweep = RollingSweep(0.0, 0.0, 0.0),
    velocity: tuple[float, float] = (0.0, 0.0),
    hidden: Sequence[Box] = (),
) -> VehicleScan:
    """What a LiDAR measures of boxes that all move with one velocity, on ground that stands.

    Args:
        boxes: Where the boxes are at the instant.
        pose: True pose of the velodyne at the scan's time.
        time: The scan's time after the instant.
        sweep: How the scan comes about.
        velocity: Of the boxes, m/s.
        hidden: Boxes that stand there, but of which the scan has nothing: their rays are lost.
    """
    points = []
    for elevation in np.radians(np.arange(-24.0, 2.0, 0.4)):
        for azimuth in np.radians(np.arange(-180.0, 180.0, 0.5)):
            when = azimuth * sweep.period / (2 * np.pi)
            # Where the sensor is at the ray's own time.
            turn, ahead = sweep.turn_rate * when, sweep.speed * when
            here = pose @ np.array(
                [
                    [np.cos(turn), -np.sin(turn), 0, ahead * np.cos(turn / 2)],
                    [np.sin(turn), np.cos(turn), 0, ahead * np.sin(turn / 2)],
                    [0, 0, 1, 0],
                    [0, 0, 0, 1],
                ]
            )
            own = np.array(
                [
                    np.cos(elevation) * np.cos(azimuth),
                    np.cos(elevation) * np.sin(azimuth),
                    np.sin(elevation),
                ]
            )
            ray, origin = here[:3, :3] @ own, here[:3, 3] + [0, 0, TIP]
            shift = (time + when) * np.array([*velocity, 0.0])
            met = [_meets(origin - shift, ray, box) for box in boxes]
            lost = [_meets(origin - shift, ray, box) for box in hidden]
            ground = -origin[2] / ray[2] if ray[2] < 0 else np.inf
            far = min([*met, ground])
            if far < 80.0 and min([*lost, np.inf]) > far:
                points.append([*(far * own + [0, 0, TIP]), 0.5])
    return VehicleScan(np.array(points, np.float32), pose, time)


def _meets(origin: Floats, ray: Floats, box: Box) -> float:
    low, high = np.array(box[::2]), np.array(box[1::2])
    with np.errstate(divide="ignore", invalid="ignore"):
        faces = np.stack([low - origin, high - origin]) / ray
    enters, leaves = faces.min(axis=0).max(), faces.max(axis=0).min()
    return float(enters) if 0 < enters <= leaves else np.inf
