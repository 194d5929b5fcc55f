"""Procedural drives: the world's own road, and its simulated traffic as recorded actors.

The car takes the place of the drive's sensor vehicle.  Side streets are left out: the road has no
junctions.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from avsec_gym.closed_loop.rendered_sensors import RenderedSensors
from avsec_gym.closed_loop.tracks import STEP, Tracks
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.geometry import Floats
from avsec_gym.rig import SensorRig
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.lanes_across import LaneAcross, lanes_along
from avsec_gym.scenario.planning_scenario import EgoState
from avsec_gym.scenario.road import Road
from avsec_gym.world.assets import Assets
from avsec_gym.world.drives import DriveWorld, drive_scenes
from avsec_gym.world.site import Course, CrossSection, Style

_CAMERA_HEIGHT = 1.65
_BEYOND = 120.0
"""Metres of road beyond the course's ends, which runs on straight there."""
_SPACING = 4.0
"""Metres between the points of lanes, less where the road bends most."""
_SPEED_STEP = 0.5
"""Start speeds are rounded to it, m/s, so that drives share their motion primitives."""
_LEAST_SPEED = 4.0
"""m/s; slower drives would not get anywhere in 8 s."""


@lru_cache(maxsize=128)
def procedural_drive(
    seed: int,
    number: int,
    *,
    people: bool = True,
    duration: float = 8.0,
    rig: SensorRig | None = None,
    vehicles: int = 1,
    assets: Assets = Assets.ALL,
) -> TrafficScene:
    """A drive of the procedural world.

    Args:
        seed: Seed of the set of drives.
        number: Number of the drive in the set.
        people: Whether pedestrians and cyclists are there.
        duration: Seconds of recorded traffic at least.
        rig: The sensors that the car carries; None: KITTI's.
        vehicles: The number of vehicles with sensors: the car, and those that are connected with
            it.  The traffic of a drive depends on it.
        assets: The part of the assets that place and actors are made of.
    """
    frames = math.ceil(duration / STEP) + 2
    scenes = drive_scenes(seed, number, frames=frames, egos=vehicles, rig=rig, assets=assets)
    world = scenes.world
    ego = world.instants[0].egos[0]
    first = world.instants[0].actors
    speed = max(_SPEED_STEP * round(float(first.speed[ego]) / _SPEED_STEP), _LEAST_SPEED)
    x, y, heading = first.pose[ego].tolist()
    highway = world.site.style == Style.HIGHWAY
    return TrafficScene(
        id=f"{drive_prefix(seed, vehicles, assets)}-{number:06d}",
        road=road_of(world.site.course, world.site.section),
        road_type=RoadType.HIGHWAY if highway else RoadType.STREET,
        start=EgoState(x, y, speed, heading),
        tracks=_tracks(world, int(first.id[ego]), people),
        cruise=_cruise(speed, highway),
        sensors=RenderedSensors(scenes),
    )


def drive_prefix(seed: int, vehicles: int = 1, assets: Assets = Assets.ALL) -> str:
    """What the ids of a set of procedural drives begin with; see `procedural_drive`."""
    named = "drive" if seed == 0 else f"drive-s{seed}"
    named = named if vehicles == 1 else f"{named}-v{vehicles}"
    return named if assets == Assets.ALL else f"{named}-{assets}"


def _cruise(speed: float, highway: bool) -> tuple[float, float]:
    """The speeds that the car wants to keep: those of its start, by primitives' steps of 2 m/s."""
    usual = driving_constraints(RoadType.HIGHWAY if highway else RoadType.STREET).goal_velocity
    return usual if usual[0] == speed else (speed, speed + 2.0)


def road_of(course: Course, section: CrossSection) -> Road:
    """The lanes of a road, each one lanelet; the outermost reach to the carriageway's edges.

    Args:
        course: Where the road runs.
        section: What lies across it; lanes run along the course or against it.
    """
    along = np.arange(course.start - _BEYOND, course.end + _BEYOND, _SPACING)
    lanes = [
        LaneAcross(lane.left - 0.5 * lane.width, lane.left + 0.5 * lane.width, lane.direction)
        for lane in section.lanes
    ]
    right, left = section.carriageway
    lanes[0] = replace(lanes[0], right=min(lanes[0].right, right))
    lanes[-1] = replace(lanes[-1], left=max(lanes[-1].left, left))

    def points(left: float) -> Floats:
        return course.poses(along, np.full(len(along), left))[:, :2]

    return Road(lanes_along(points, lanes))


def _tracks(world: DriveWorld, ego: int, people: bool) -> Tracks:
    """The actors of a drive but the car, those that ever move and those that stand."""
    instants = (*world.instants, world.after)
    rows: dict[int, int] = {}
    for instant in instants:
        for id, category in zip(
            instant.actors.id.tolist(), instant.actors.category.tolist(), strict=True
        ):
            if id != ego and (
                people or category not in ("Pedestrian", "Cyclist", "Person_sitting")
            ):
                rows.setdefault(id, len(rows))
    count, steps = len(rows), len(instants)
    poses, speeds = np.zeros((count, steps, 3)), np.zeros((count, steps))
    dimensions, categories = np.ones((count, 3)), np.full(count, "", dtype="U16")
    first, last = np.full(count, steps), np.full(count, -1)
    for step, instant in enumerate(instants):
        actors = instant.actors
        kept = np.array([id in rows for id in actors.id.tolist()], bool)
        at = np.array([rows[id] for id in actors.id[kept].tolist()], int)
        poses[at, step], speeds[at, step] = actors.pose[kept], actors.speed[kept]
        dimensions[at], categories[at] = actors.dimensions[kept], actors.category[kept]
        first[at], last[at] = np.minimum(first[at], step), step
    return Tracks(
        ids=np.array(list(rows), np.int64),
        categories=categories,
        dimensions=dimensions,
        poses=poses,
        speeds=speeds,
        first=first,
        last=last,
        below=np.full(count, _CAMERA_HEIGHT),
    )
