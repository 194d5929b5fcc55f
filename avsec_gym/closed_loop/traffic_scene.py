"""A scene to drive in: a road, a start, recorded actors, and how far to go."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import shapely

from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.closed_loop.relative_poses import Pose
from avsec_gym.closed_loop.tracks import STEP, Tracks
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import LANE_WIDTH, is_obstacle
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.given_scene import GivenScene
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState
from avsec_gym.scenario.road import Road, straight_lanes
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.shapes import placed

LANES = 27
"""As many lanes as on the authors' map, so that the road's edge never binds; also in the
planner's."""
DURATION = 8.0
"""Seconds that a drive takes by default, and that tracks cover at least."""
_BEHIND, _AHEAD = 60.0, 640.0
"""Metres of straight road behind and ahead of the start."""
_LONGEST = 30.0
"""Seconds for which actors at constant velocity are recorded; they stand then."""
_SIZE_OF_PEOPLE = 1.7
"""Height that stands for the unknown one of an obstacle of a CommonRoad file, metres."""

SensorRenderer = Callable[[float, Pose, dict[int, Pose]], SensorFrame]
"""What the sensors deliver at a time (s) where the car and, by their ids, all others are."""


@dataclass(frozen=True, eq=False)
class TrafficScene:
    """A scene to drive in.

    Args:
        id: Id of the scene.
        road: The lanelets; only what they cover may be driven on.
        road_type: Street or highway.
        start: The car's state at the start.
        tracks: The recorded actors, without the car.
        cruise: Least and highest speed that the car wants to drive at, m/s.
        sensors: What the car's sensors deliver; None: there is no sensor data.
        sets_off: Time in the tracks at which the drive begins, seconds.
    """

    id: str
    road: Road
    road_type: RoadType
    start: EgoState
    tracks: Tracks
    cruise: tuple[float, float]
    sensors: SensorRenderer | None = None
    sets_off: float = 0.0

    @cached_property
    def lanes(self) -> Lanes:
        """The lanes of the road; scenes on one road share them."""
        return _lanes_of(self.road)

    @cached_property
    def start_lane(self) -> int:
        """The id of the lanelet that the drive begins in."""
        return self.lanes.at(self.start.x, self.start.y, self.start.heading)

    @property
    def intentions(self) -> tuple[Intention, ...]:
        """The intentions that lead to a lane of the car's own direction."""
        return self.lanes.intentions(self.start_lane)

    def target_lane(self, intention: Intention) -> int:
        """The lanelet beside the start's that an intention leads to.

        Raises:
            ConfigurationError: None of the car's direction is there.
        """
        lane = self.lanes.beside(self.start_lane, intention)
        if lane is None:
            known = ", ".join(self.intentions)
            raise ConfigurationError(
                f"{self.id}: no lane lies to the {intention}; intentions here: {known}"
            )
        return lane

    @property
    def drivable(self) -> shapely.Geometry:
        """The area that may be driven on, prepared for many questions."""
        return self.lanes.drivable


@lru_cache(maxsize=16)
def _lanes_of(road: Road) -> Lanes:
    return Lanes(road)


@lru_cache(maxsize=1)
def thesis_road() -> Road:
    """The authors' straight lanes, long enough for a drive."""
    return Road(straight_lanes(LANES, LANE_WIDTH, -_BEHIND, _AHEAD))


def scene_on_straight_lanes(scene: Scene, *, people: bool = True) -> TrafficScene:
    """A labelled scene, its movers at constant velocity, on the thesis' straight lanes.

    The world frame is the ego frame of the label file; the car starts as in a single query.

    Args:
        scene: The labelled scene.
        people: Whether pedestrians, cyclists and others that the thesis leaves out are there.
    """
    boxes, speeds = scene.boxes, scene.speeds
    kept = np.all(boxes.dimensions > 0, axis=1) & (people | is_obstacle(boxes))
    boxes, speeds = boxes[kept], speeds[kept]
    tracks = Tracks.at_constant_velocity(
        boxes.category,
        boxes.dimensions,
        boxes.poses,
        speeds,
        boxes.location[:, 1],
        round(_LONGEST / STEP),
    )
    return TrafficScene(
        id=scene.id,
        road=thesis_road(),
        road_type=scene.road_type,
        start=EgoState(velocity=scene.start_speed),
        tracks=tracks,
        cruise=driving_constraints(scene.road_type).goal_velocity,
    )


def scene_of_commonroad(scene: GivenScene) -> TrafficScene:
    """The road, the start and the recorded obstacles of a CommonRoad file; its goal is not used.

    Args:
        scene: The file's planning problem.

    Raises:
        ConfigurationError: The file has no lanelets.
    """
    scenario = scene.scenario
    start = scenario.start
    road_type = RoadType.STREET if start.velocity < 10.0 else RoadType.HIGHWAY
    speed = max(start.velocity, driving_constraints(road_type).goal_velocity[0])
    if not scenario.road.lanelets:
        raise ConfigurationError(f"{scenario.id} has no lanelets: there is no road to drive on")
    return TrafficScene(
        id=scenario.id,
        road=scenario.road,
        road_type=scenario.road_type or road_type,
        start=start,
        tracks=_tracks_of(scenario.obstacles, scenario.dt),
        cruise=(speed, speed + 2.0),
        sets_off=start.step * scenario.dt,
    )


def _tracks_of(obstacles: Obstacles, dt: float) -> Tracks:
    """Obstacles of a CommonRoad file; standing ones are there for ever, others while recorded."""
    count, steps = len(obstacles), math.ceil(_LONGEST / STEP)
    ends = obstacles.first_step + obstacles.steps
    steps = max(steps, int(ends.max(initial=1) * dt / STEP))
    poses, speeds = np.zeros((count, steps + 1, 3)), np.zeros((count, steps + 1))
    dimensions = np.zeros((count, 3))
    first = np.zeros(count, np.int64)
    last = np.full(count, steps)
    for i, shape in enumerate(obstacles.shapes):
        # The smallest rectangle along the obstacle's heading that holds its shape.
        low_x, low_y, high_x, high_y = placed(shape, np.zeros(3)).bounds
        dimensions[i] = _SIZE_OF_PEOPLE, high_y - low_y, high_x - low_x
        own = obstacles.poses[i].copy()
        own[:, 2] = np.unwrap(own[:, 2])
        cos, sin = np.cos(own[:, 2]), np.sin(own[:, 2])
        middle_x, middle_y = 0.5 * (low_x + high_x), 0.5 * (low_y + high_y)
        own[:, 0] += cos * middle_x - sin * middle_y
        own[:, 1] += sin * middle_x + cos * middle_y
        if obstacles.static[i]:
            poses[i] = own[0]
            continue
        first[i] = math.ceil(obstacles.first_step[i] * dt / STEP - 1e-9)
        last[i] = math.floor((ends[i] - 1) * dt / STEP + 1e-9)
        times = (obstacles.first_step[i] + np.arange(obstacles.steps[i])) * dt
        at = STEP * np.arange(steps + 1)
        known = own[: obstacles.steps[i]]
        poses[i] = np.column_stack([np.interp(at, times, column) for column in known.T])
        speeds[i] = np.interp(at, times, obstacles.speeds[i, : obstacles.steps[i]])
    return Tracks(
        ids=np.asarray(obstacles.ids, np.int64),
        categories=np.array(
            [_CATEGORIES.get(str(c), "Car") for c in obstacles.categories], np.str_
        ),
        dimensions=dimensions,
        poses=poses,
        speeds=speeds,
        first=first,
        last=last,
        below=np.full(count, 1.65),
    )


_CATEGORIES = {
    "pedestrian": "Pedestrian",
    "bicycle": "Cyclist",
    "motorcycle": "Cyclist",
    "truck": "Truck",
    "bus": "Truck",
    "train": "Tram",
}
"""KITTI's names of CommonRoad's obstacle types; all others are cars."""
