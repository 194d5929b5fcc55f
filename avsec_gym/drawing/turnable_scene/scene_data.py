"""What a turnable scene shows: metres in the ego frame, x forward, y left, z up from the ground."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.pipeline import Episode
from avsec_gym.planners.vehicle import BMW_320I, Vehicle
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.planning_scenario import PlanningScenario

_AHEAD, _ASIDE = (-20.0, 60.0), 25.0
"""Metres that are shown, from behind to ahead of the start, and to either side."""
_CAMERA_HEIGHT = 1.65
"""Metres above the ground, as KITTI mounts it and the procedural world does."""
_CAR_HEIGHT = 1.45
_MOST_POINTS = 6000
"""Most points of a scan; more hide what they hit, and make the page heavy."""
_CENTIMETRES = 100


@dataclass(frozen=True, eq=False)
class ShownBox:
    """An upright box, which stands or moves.

    Args:
        size: Length, width and height, metres.
        bottom: Height of its bottom above the ground, metres.
        poses: x, y and heading at each time step, shape (T, 3); one row: it stands.
    """

    size: tuple[float, float, float]
    bottom: float
    poses: Floats

    def to_json(self) -> dict[str, Any]:
        """The box for the page."""
        return {
            "size": _rounded(self.size),
            "bottom": round(self.bottom, 2),
            "poses": _rounded(self.poses, 3),
        }


@dataclass(frozen=True, eq=False)
class ShownEpisode:
    """An episode by one belief.

    Args:
        title: What was done to the car.
        outcome: ``safe``, ``collision`` or ``unplanned``.
        real: What is really there while it drives.
        believed: What the car believes at its start.
        car: The car's centre and heading at each time step up to a collision, shape (T, 3).
        planned: The trajectory that it planned, shape (P, 2); empty without a plan.
    """

    title: str
    outcome: str
    real: tuple[ShownBox, ...]
    believed: tuple[ShownBox, ...]
    car: Floats
    planned: Floats

    def to_json(self) -> dict[str, Any]:
        """The vehicle for the page."""
        return {
            "title": self.title,
            "outcome": self.outcome,
            "real": [each.to_json() for each in self.real],
            "believed": [each.to_json() for each in self.believed],
            "car": _rounded(self.car, 3),
            "planned": _rounded(self.planned),
        }


@dataclass(frozen=True, eq=False)
class TurnableScene:
    """A scene and one episode or more through it.

    Args:
        title: Names the scene for who cannot see it.
        dt: Duration of a time step, seconds.
        lanes: Borders of the lanes, shape (N, 2) each.
        goal: Corners of the goal regions, shape (N, 2) each.
        points: Points of the scan, shape (M, 3); empty where nothing was scanned.
        vehicle: Length, width and height of the car, metres.
        episodes: The episodes, of which one is shown at a time.
    """

    title: str
    dt: float
    lanes: tuple[Floats, ...]
    goal: tuple[Floats, ...]
    points: Floats
    vehicle: tuple[float, float, float]
    episodes: tuple[ShownEpisode, ...]

    def to_json(self) -> dict[str, Any]:
        """The scene for the page; points as 16-bit whole centimetres, little-endian, in base 64."""
        whole = np.rint(self.points * _CENTIMETRES).astype("<i2")
        return {
            "dt": self.dt,
            "lanes": [_rounded(each) for each in self.lanes],
            "goal": [_rounded(each) for each in self.goal],
            "points": base64.b64encode(whole.tobytes()).decode(),
            "vehicle": _rounded(self.vehicle),
            "drives": [each.to_json() for each in self.episodes],
        }


@dataclass(frozen=True, eq=False)
class DrivenBelief:
    """An episode, and the belief that it was planned on.

    Args:
        title: What was done to the car.
        episode: The plan and its check.
        believed: The boxes that the car believed in.
    """

    title: str
    episode: Episode
    believed: Boxes3D


def turnable_scene(
    title: str,
    driven: Sequence[DrivenBelief],
    truth: Boxes3D,
    *,
    frame: SensorFrame | None = None,
    vehicle: Vehicle = BMW_320I,
) -> TurnableScene:
    """Episodes through one scene from one start.

    Args:
        title: Names the scene.
        driven: The episodes.
        truth: The labelled objects, those that are obstacles in the order of `Episode.truth`.
        frame: The frame whose scan is shown, if it has one.
        vehicle: The vehicle that drives.
    """
    problem = driven[0].episode.problem
    return TurnableScene(
        title,
        problem.dt,
        tuple(_shown_bounds(problem)),
        tuple(
            np.array(shape.polygon().exterior.coords[:-1])
            for goal in problem.goals
            for shape in goal.region or ()
        ),
        _scan(frame),
        (vehicle.length, vehicle.width, _CAR_HEIGHT),
        tuple(_episode(belief, truth) for belief in driven),
    )


def _episode(driven: DrivenBelief, truth: Boxes3D) -> ShownEpisode:
    episode, believed = driven.episode, driven.believed[is_obstacle(driven.believed)]
    record = episode.record
    planned = np.zeros((0, 3))
    if episode.plan.trajectory is not None:
        planned = episode.plan.trajectory[:, [0, 1, 3]]
    start = episode.problem.start
    car = planned if len(planned) else np.array([[start.x, start.y, start.heading]])
    if record.collision:
        car = car[: round(record.collision_time / episode.problem.dt) + 1]
    rows = zip(believed.poses, _sizes(believed), _bottoms(believed), strict=True)
    return ShownEpisode(
        driven.title,
        record.outcome,
        tuple(_real(episode, truth, len(car))),
        tuple(ShownBox(size, bottom, pose[None]) for pose, size, bottom in rows),
        car,
        planned[:, :2],
    )


def _real(episode: Episode, truth: Boxes3D, steps: int) -> list[ShownBox]:
    """Obstacles near the car; who walks or cycles is none, as with the thesis' authors."""
    boxes = truth[is_obstacle(truth)]
    obstacles, first = episode.truth, episode.problem.start.step
    index = np.array([obstacles.pose_index(first + step) for step in range(steps)]).T
    shown = []
    for number, (pose, size, bottom) in enumerate(
        zip(boxes.poses, _sizes(boxes), _bottoms(boxes), strict=True)
    ):
        poses = pose[None]
        if not obstacles.static[number]:
            poses = obstacles.poses[number, np.maximum(index[number], 0)]
        if _is_near(pose[0], pose[1]):
            shown.append(ShownBox(size, bottom, poses))
    return shown


def _sizes(boxes: Boxes3D) -> list[tuple[float, float, float]]:
    """Length, width and height of each box."""
    return [(float(row[2]), float(row[1]), float(row[0])) for row in boxes.dimensions]


def _bottoms(boxes: Boxes3D) -> list[float]:
    """Height of each bottom above the ground, which lies as far below the camera as KITTI's."""
    return [float(_CAMERA_HEIGHT - y) for y in boxes.location[:, 1]]


def _scan(frame: SensorFrame | None) -> Floats:
    """Points of the scan, evenly thinned out, shape (M, 3)."""
    if frame is None or not frame.has_points:
        return np.zeros((0, 3))
    x, y, z = transform_points(frame.calibration.velodyne_to_camera, frame.points[:, :3]).T
    places = np.stack([z, -x, _CAMERA_HEIGHT - y], axis=1)
    places = places[[_is_near(*place) for place in places[:, :2]]]
    return np.asarray(places[:: max(1, -(-len(places) // _MOST_POINTS))])


def _shown_bounds(problem: PlanningScenario) -> list[Floats]:
    """Borders of lanes near the car, each once, cut off where the picture ends."""
    bounds = {side for lane in problem.road.lanelets for side in (lane.left, lane.right)}
    shown = []
    for bound in sorted(bounds):
        points = np.array(bound, float)
        if np.abs(points[:, 1]).min() < _ASIDE / 2:
            points[:, 0] = points[:, 0].clip(*_AHEAD)
            shown.append(points)
    return shown


def _is_near(x: float, y: float) -> bool:
    return _AHEAD[0] <= x <= _AHEAD[1] and abs(y) <= _ASIDE


def _rounded(values: Any, digits: int = 2) -> Any:
    return np.round(np.asarray(values, float), digits).tolist()
