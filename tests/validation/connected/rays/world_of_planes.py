"""A world of upright boxes on flat ground, scanned ray by ray: the tests' judge."""

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
    elevation, azimuth = (
        angles.ravel()
        for angles in np.meshgrid(
            np.radians(np.arange(-24.0, 2.0, 0.4)), np.radians(np.arange(-180.0, 180.0, 0.5)),
            indexing="ij",
        )
    )  # fmt: skip
    when = azimuth * sweep.period / (2 * np.pi)
    # Where the sensor is at each ray's own time.
    turn, ahead = sweep.turn_rate * when, sweep.speed * when
    here = np.zeros((len(when), 4, 4))
    here[:, 0, 0], here[:, 0, 1] = np.cos(turn), -np.sin(turn)
    here[:, 1, 0], here[:, 1, 1] = np.sin(turn), np.cos(turn)
    here[:, 0, 3], here[:, 1, 3] = ahead * np.cos(turn / 2), ahead * np.sin(turn / 2)
    here[:, 2, 2] = here[:, 3, 3] = 1
    here = pose @ here
    own = np.c_[
        np.cos(elevation) * np.cos(azimuth),
        np.cos(elevation) * np.sin(azimuth),
        np.sin(elevation),
    ]
    rays = np.einsum("nij,nj->ni", here[:, :3, :3], own)
    origins = here[:, :3, 3] + [0, 0, TIP]
    moved = origins - (time + when)[:, None] * [*velocity, 0.0]
    far = np.full(len(rays), np.inf)
    np.divide(-origins[:, 2], rays[:, 2], out=far, where=rays[:, 2] < 0)
    for box in boxes:
        far = np.minimum(far, _meets(moved, rays, box))
    lost = np.full(len(rays), np.inf)
    for box in hidden:
        lost = np.minimum(lost, _meets(moved, rays, box))
    seen = (far < 80.0) & (lost > far)
    points = far[seen, None] * own[seen] + [0, 0, TIP]
    scan = np.c_[points, np.full(len(points), 0.5)].astype(np.float32)
    return VehicleScan(scan, pose, time, sweep)


def _meets(origins: Floats, rays: Floats, box: Box) -> Floats:
    """How far along each ray the box begins; infinite where it is missed."""
    low, high = np.array(box[::2]), np.array(box[1::2])
    with np.errstate(divide="ignore", invalid="ignore"):
        faces = np.stack([low - origins, high - origins]) / rays
    enters, leaves = faces.min(axis=0).max(axis=1), faces.max(axis=0).min(axis=1)
    return np.where((enters > 0) & (enters <= leaves), enters, np.inf)
