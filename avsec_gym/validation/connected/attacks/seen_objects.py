"""The objects that a vehicle's scan has points on: labelled ones, or what looks like objects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.validation.connected.merging import regions_in_world
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.regions import Regions


@dataclass(frozen=True, eq=False)
class SeenObject:
    """An object in a vehicle's scan.

    Args:
        pose: The transform from the object's own frame (x along its heading, z up from its bottom)
            to the velodyne frame of the scan's own time, as it was when the LiDAR's head
            faced it, shape (4, 4).
        dimensions: Height, width, length, metres.
        points: Number of points in its box.
        speed: Speed, m/s; 0 where it is not known.
        category: KITTI's name of what it is; empty without labels.
        actor: Its number, the same over a drive; None without labels.
    """

    pose: Floats
    dimensions: tuple[float, float, float]
    points: int
    speed: float = 0.0
    category: str = ""
    actor: int | None = None

    @property
    def distance(self) -> float:
        """The distance from the LiDAR along the ground, metres."""
        return float(np.hypot(*self.pose[:2, 3]))


def seen_objects(instant: RecordedInstant, vehicle: int, fewest: int = 1) -> list[SeenObject]:
    """The objects that a vehicle has points on, nearest first.

    Without labels, they are what `ClusterProposer` takes for objects.

    Args:
        instant: What all vehicles scanned.
        vehicle: Number of the vehicle.
        fewest: Points that an object has at least; with 0, labelled ones that are hidden from the
            vehicle are among them.
    """
    scan = instant.scans[vehicle].compensated()
    places = scan.points[:, :3].astype(np.float64)
    objects = _labelled(instant, vehicle) if instant.truth else _proposed(instant, vehicle)
    found = []
    for pose, dimensions, speed, category, actor in objects:
        points = points_in_box(places, pose, dimensions)
        if points >= fewest:
            found.append(SeenObject(pose, dimensions, points, speed, category, actor))
    return sorted(found, key=lambda each: each.distance)


_Box = tuple[Floats, tuple[float, float, float], float, str, int | None]


def _labelled(instant: RecordedInstant, vehicle: int) -> list[_Box]:
    truth, scan = instant.truth, instant.scans[vehicle]
    assert truth is not None
    to_velodyne = np.linalg.inv(instant.true_pose(vehicle))
    own = truth.vehicles[vehicle].actor
    boxes: list[_Box] = []
    for each in truth.objects:
        if each.actor == own:
            continue
        # What moves is where it is when the head faces it.
        place = to_velodyne @ [*each.location, 1.0]
        faced = scan.time + float(scan.sweep.facing_time(*place[:2]))
        x, y, heading = each.pose_after(faced)
        pose = to_velodyne @ upright_pose(x, y, each.location[2], heading)
        boxes.append((pose, each.dimensions, each.speed, each.category, each.actor))
    return boxes


def _proposed(instant: RecordedInstant, vehicle: int) -> list[_Box]:
    regions = ClusterProposer()(instant.scans[vehicle].compensated().points)
    return [
        (upright_pose(x, y, z, heading), (size[2], size[1], size[0]), 0.0, "", None)
        for (x, y, z), size, heading in zip(
            regions.centre.tolist(), regions.size.tolist(), regions.heading.tolist(), strict=True
        )
    ]


def upright_pose(x: float, y: float, z: float, heading: float) -> Floats:
    """The pose of an upright thing, shape (4, 4)."""
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array([[cos, -sin, 0, x], [sin, cos, 0, y], [0, 0, 1, z], [0, 0, 0, 1.0]])


def points_in_box(
    places: Floats, pose: Floats, dimensions: tuple[float, float, float], feet: float = 0.1
) -> int:
    """Number of points in an object's box, without those of the ground at its feet."""
    return int(_count_inside(places, np.ascontiguousarray(pose), *dimensions, feet))


@kernel(nogil=True)
def _count_inside(
    places: Floats, pose: Floats, height: float, width: float, length: float, feet: float
) -> int:
    count = 0
    for i in range(len(places)):
        x, y = places[i, 0] - pose[0, 3], places[i, 1] - pose[1, 3]
        z = places[i, 2] - pose[2, 3]
        along = x * pose[0, 0] + y * pose[1, 0] + z * pose[2, 0]
        across = x * pose[0, 1] + y * pose[1, 1] + z * pose[2, 1]
        up = x * pose[0, 2] + y * pose[1, 2] + z * pose[2, 2]
        if abs(along) <= length / 2 and abs(across) <= width / 2 and feet < up <= height:
            count += 1
    return count


def box_in_world(pose: Floats, dimensions: tuple[float, float, float], vehicle: Floats) -> Regions:
    """An object's box of a vehicle's frame, in the world of all vehicles, one region.

    Args:
        pose: The transform from the object's frame to the velodyne frame, shape (4, 4).
        dimensions: Height, width, length, metres.
        vehicle: Pose of the velodyne frame, shape (4, 4).
    """
    height, width, length = dimensions
    heading = float(np.arctan2(pose[1, 0], pose[0, 0]))
    own = Regions(pose[None, :3, 3], np.array([[length, width, height]]), np.array([heading]))
    return regions_in_world(own, vehicle)
