"""Attacks on a scan alone: an object of another scan appears, or one of its own disappears."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.object_scan import ObjectScan
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Points
from avsec_gym.geometry import Floats, transform_points

RemovedRays = Literal["lost", "pushed"]
"""Rays of a removed object return nothing, or from the ground behind it."""


@dataclass(frozen=True, eq=False)
class TamperedScan:
    """A scan as the vehicle gets it, and what was done to it; the vehicle sees the points alone.

    Args:
        points: The scan, velodyne frame, shape (M, 4).
        bogus: Whether each of its points was put there by the attacker, shape (M,).
        lost: Whether each point of the clean scan is gone, shape (M of the clean scan,).
    """

    points: Points
    bogus: NDArray[np.bool_]
    lost: NDArray[np.bool_]


def holds_lidar(to_velodyne: Floats, dimensions: tuple[float, float, float]) -> bool:
    """Whether the LiDAR would be inside of an object's box.

    Args:
        to_velodyne: Pose of the object: from its own frame to the velodyne frame, shape (4, 4).
        dimensions: The box's height, width and length, metres.
    """
    sensor, low, high = _box_frame(to_velodyne, dimensions)
    return bool(((sensor > low) & (sensor < high)).all())


def inject_object(
    points: Points, scan: ObjectScan, to_velodyne: Floats, *, rays_lost: bool = False
) -> TamperedScan:
    """A scan with an object's points after its own (thesis, section 4.5).

    The points stay where they are on the object: what was scanned from afar is sparse nearby.

    Args:
        points: The clean scan, velodyne frame, shape (M, 4).
        scan: The scan of the object that is pasted.
        to_velodyne: Pose of the object: from its own frame to the velodyne frame, shape (4, 4).
        rays_lost: Whether beams that meet the object's box return nothing from in or behind it.

    Raises:
        ConfigurationError: The LiDAR would be inside of the box.
    """
    if holds_lidar(to_velodyne, scan.dimensions):
        x, y = to_velodyne[:2, 3].tolist()
        raise ConfigurationError(f"an object at x {x:.2f}, y {y:.2f} m would have the LiDAR in it")
    pasted = scan.points.copy()
    pasted[:, :3] = transform_points(to_velodyne, scan.points[:, :3])
    lost = np.zeros(len(points), bool)
    if rays_lost:
        sensor, low, high = _box_frame(to_velodyne, scan.dimensions)
        ends = transform_points(np.linalg.inv(to_velodyne), points[:, :3])
        lost = _rays_into_box(sensor, ends, low, high)
    kept = points[~lost]
    bogus = np.arange(len(kept) + len(pasted)) >= len(kept)
    return TamperedScan(np.concatenate([kept, pasted]), bogus, lost)


def remove_object(
    points: Points,
    to_velodyne: Floats,
    dimensions: tuple[float, float, float],
    rays: RemovedRays = "lost",
    margin: float = 0.15,
) -> TamperedScan:
    """A scan without an object: the attacker outshines its echoes, or delays them.

    Args:
        points: The clean scan, velodyne frame, shape (M, 4).
        to_velodyne: Pose of the object: from its own frame to the velodyne frame, shape (4, 4).
        dimensions: Height, width, length of its box, metres.
        rays: Whether its rays return nothing, or from the ground behind the object, on the plane of
            its bottom; rays that never meet that plane within 80 m return nothing.
        margin: Points so far beside the box are removed, too, metres; those of the ground at its
            foot stay.

    Raises:
        ConfigurationError: Rays are something else than lost or pushed.
    """
    if rays not in ("lost", "pushed"):
        raise ConfigurationError(f"rays are 'lost' or 'pushed', got {rays!r}")
    sensor, low, high = _box_frame(to_velodyne, dimensions)
    own = transform_points(np.linalg.inv(to_velodyne), points[:, :3])
    of_object = ((own >= low - margin) & (own <= high + margin)).all(axis=1)
    of_object &= own[:, 2] > _FOOT
    pushed = np.zeros((0, 4), np.float32)
    if rays == "pushed":
        pushed = _to_ground(sensor, own[of_object], points[of_object, 3], to_velodyne)
    kept = points[~of_object]
    bogus = np.arange(len(kept) + len(pushed)) >= len(kept)
    return TamperedScan(np.concatenate([kept, pushed]), bogus, of_object)


_FOOT = 0.1
"""Metres above an object's bottom: what is lower is the ground's."""
_REACH = 80.0


def _to_ground(sensor: Floats, ends: Floats, reflectance: Floats, to_velodyne: Floats) -> Points:
    """Where rays meet the plane of an object's bottom; those that do within reach, (K, 4)."""
    direction = ends - sensor
    with np.errstate(divide="ignore", invalid="ignore"):
        stretch = -sensor[2] / direction[:, 2]
    grounds = (direction[:, 2] < 0) & (stretch >= 1)
    grounds &= stretch * np.linalg.norm(direction, axis=1) <= _REACH
    places = sensor + stretch[grounds, None] * direction[grounds]
    moved = transform_points(to_velodyne, places)
    return np.c_[moved, reflectance[grounds]].astype(np.float32)


def _box_frame(
    to_velodyne: Floats, dimensions: tuple[float, float, float]
) -> tuple[Floats, Floats, Floats]:
    """The LiDAR's place in an object's own frame, and the box's lowest and highest corner."""
    height, width, length = dimensions
    low, high = np.array([[-length, -width, 0.0], [length, width, 2 * height]]) / 2
    sensor: Floats = np.linalg.inv(np.asarray(to_velodyne, np.float64))[:3, 3]
    return sensor, low, high


def _rays_into_box(origin: Floats, ends: Floats, low: Floats, high: Floats) -> NDArray[np.bool_]:
    """Which rays enter a box, upright in this frame, before they end; shape (N,)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        faces = np.stack([low - origin, high - origin])[:, None] / (ends - origin)
    enters, leaves = faces.min(axis=0).max(axis=1), faces.max(axis=0).min(axis=1)
    return np.asarray((enters <= leaves) & (leaves > 0) & (enters < 1))
