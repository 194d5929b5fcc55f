"""A street with a car, as three vehicles scan it: rays on boxes and the ground, by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from avsec_gym.geometry import transform_points
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

Box = tuple[float, float, float]
"""x, y, heading of a car of 4.2 x 1.8 x 1.5 m in the world."""
_SIZE = np.array([4.2, 1.8, 1.5])
CARS: tuple[Box, ...] = (
    (14, 3, -0.1),
    (22, -3, 0.3),
    (8, -6, 1.2),
    (30, 7, -0.5),
    (18, 9, 0.2),
)
"""A street on which a liar is searched for."""


def pose_at(x: float, y: float, heading: float) -> np.ndarray:
    """Pose of a velodyne 1.73 m above the ground."""
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array([[cos, -sin, 0, x], [sin, cos, 0, y], [0, 0, 1, 1.73], [0, 0, 0, 1]])


POSES = (pose_at(0, 0, 0), pose_at(34, 2, np.pi), pose_at(14, -14, np.pi / 2))
"""Of the three honest vehicles there."""


def car_regions(*boxes: Box) -> Regions:
    """The true boxes."""
    place = np.array(boxes).reshape(-1, 3)
    centre = np.c_[place[:, :2], np.zeros(len(place))]
    return Regions(centre, np.tile(_SIZE, (len(place), 1)), place[:, 2])


def scan_of(pose: np.ndarray, *boxes: Box) -> VehicleScan:
    """What rays of 64 rings hit: the nearest of the ground and the boxes, within 60 m."""
    up, around = np.radians(np.linspace(2, -24.8, 64)), np.radians(np.arange(0, 360, 0.2))
    up, around = (axis.ravel() for axis in np.meshgrid(up, around))
    rays = np.c_[np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)]
    with np.errstate(divide="ignore"):
        reach = np.where(rays[:, 2] < 0, -1.73 / rays[:, 2], np.inf)
    regions = car_regions(*boxes)
    for index in range(len(boxes)):
        sensor = regions.local(index, pose[:3, 3][None])[0]
        tips = regions.local(index, transform_points(pose, rays))
        half = _SIZE / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            faces = np.stack([-half, half])[:, None] + [0, 0, half[2]] - sensor
            faces = faces / (tips - sensor)
        enters, leaves = faces.min(axis=0).max(axis=1), faces.max(axis=0).min(axis=1)
        hits = (enters <= leaves) & (enters > 0)
        reach = np.where(hits, np.minimum(reach, enters), reach)
    seen = reach < 60
    points = np.c_[rays[seen] * reach[seen, None], np.full(seen.sum(), 0.3)]
    return VehicleScan(points.astype(np.float32), pose)


@pytest.fixture(scope="session")
def street() -> Callable[..., list[VehicleScan]]:
    """Scans of three vehicles; each sees the boxes it is given."""

    def scans(*seen: tuple[Box, ...]) -> list[VehicleScan]:
        poses = [pose_at(0, 0, 0), pose_at(30, 2, np.pi), pose_at(14, -12, np.pi / 2)]
        return [scan_of(pose, *boxes) for pose, boxes in zip(poses, seen, strict=True)]

    return scans
