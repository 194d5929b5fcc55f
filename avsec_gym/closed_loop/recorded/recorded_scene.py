"""A window of a recording as a scene to drive in: the car takes the recorded car's place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.recorded.corridor import LEFT, RIGHT, centre_of, corridor
from avsec_gym.closed_loop.recorded.ego_motion import stands
from avsec_gym.closed_loop.recorded.recorded_motion import from_first
from avsec_gym.closed_loop.recorded.recorded_traffic import RecordedObject, world_poses
from avsec_gym.closed_loop.recorded.windows import LENGTH, SLOWEST, TIGHTEST, KnownMotion, unproven
from avsec_gym.closed_loop.tracks import STEP, Tracks
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.geometry import Floats, rectangle_polygons
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import LANE_WIDTH
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.planning_scenario import EgoState

_SPEED_STEP = 0.5
"""Start speeds are rounded to it, m/s, so that scenes share their motion primitives."""
_HIGHWAY = 10.0
"""m/s from which on a road counts as a highway, as for CommonRoad files."""
_AROUND = 60
"""Frames before and after a window in which standing objects are looked for."""
_FURTHER = 80
"""Frames after a window in which the path goes on, as far as it is known."""
_BEYOND = 20
"""Frames for which a moving object drives on where its labels end, and came before they begin."""
_SMOOTHED = 9
"""Labels over which moving objects' places are smoothed, by parabolas."""
_STANDING = 0.5
"""m/s below which an object of a recording with oxts stands."""
_DRIVING = 2.0
"""m/s from which on a vehicle shows where its lane leads."""
_PEOPLE = ("Pedestrian", "Cyclist", "Person_sitting", "Person")
_STEPS = 300
"""Steps that tracks cover: 30 s, the longest drive."""


def recorded_scene(known: KnownMotion, first: int, *, people: bool = True) -> TrafficScene:
    """The scene of a window; its frame is that of the recorded car at the first frame.

    Args:
        known: The recording and its car's motion.
        first: First frame of the window.
        people: Whether pedestrians and cyclists are there.
    """
    poses = from_first(known.poses, first)
    objects = [each for each in known.recording.objects if people or each.category not in _PEOPLE]
    tracks = _tracks(known, objects, poses, first)
    path = poses[first : _path_end(known, first) + 1, :2]
    speed = max(_SPEED_STEP * round(float(known.speeds[first]) / _SPEED_STEP), SLOWEST)
    road_type = RoadType.HIGHWAY if speed >= _HIGHWAY else RoadType.STREET
    usual = driving_constraints(road_type).goal_velocity
    return TrafficScene(
        id=scene_id(known.recording.id, first),
        road=corridor(path, against=_against(tracks, path)),
        road_type=road_type,
        start=EgoState(velocity=speed),
        tracks=tracks,
        cruise=usual if usual[0] == speed else (speed, speed + 2.0),
    )


def scene_id(recording: str, first: int) -> str:
    """The id of a window's scene, such as ``0009-000120``."""
    return f"{recording}-{first:06d}"


def _path_end(known: KnownMotion, first: int) -> int:
    """The last frame up to which the path is known and is no turn."""
    end = first + LENGTH
    for last in range(end, min(end + _FURTHER, known.recording.count - 1)):
        if known.bends[last] > 1.0 / TIGHTEST:
            break
        if known.estimate is not None and unproven(known.estimate, last - LENGTH, last) is not None:
            break
        end = last
    return end


def _tracks(known: KnownMotion, objects: list[RecordedObject], poses: Floats, first: int) -> Tracks:
    """The actors of a window, in its frame and its time."""
    rows: list[Tracks] = []
    standing = (
        {each.id for each in known.estimate.standing}
        if known.estimate is not None
        else {each.id for each in objects if stands(each, known.poses, _STANDING)}
    )
    for each in objects:
        world = world_poses(each, poses)
        if each.id in standing:
            near = (each.frames >= first - _AROUND) & (each.frames <= first + LENGTH + _AROUND)
            if near.any():
                rows.append(_standing(each, np.median(world, axis=0)))
            continue
        inside = (each.frames >= first) & (each.frames <= first + LENGTH)
        if inside.any():
            rows.append(_moving(each, world, poses, first))
    return _joined(rows)


def _standing(each: RecordedObject, place: Floats) -> Tracks:
    poses = np.repeat(place[None, None], _STEPS + 1, axis=1)
    return _track(each, poses[0], np.zeros(_STEPS + 1), 0, _STEPS)


def _moving(each: RecordedObject, world: Floats, ego: Floats, first: int) -> Tracks:
    """A track through the labels: smoothed, gaps filled, driven on beyond its ends."""
    begin, end = int(each.frames[0]), int(each.frames[-1])
    frames = np.arange(begin, end + 1)
    filled = np.column_stack([np.interp(frames, each.frames, column) for column in world.T])
    if len(filled) >= _SMOOTHED:
        filled = savgol_filter(filled, _SMOOTHED, 2, axis=0)
    velocity = np.gradient(filled[:, :2], STEP, axis=0) if len(filled) > 1 else 0 * filled[:, :2]
    speeds = velocity[:, 0] * np.cos(filled[:, 2]) + velocity[:, 1] * np.sin(filled[:, 2])
    before = _driven_on(filled[0], -float(speeds[0]))[::-1]
    after = _driven_on(filled[-1], float(speeds[-1]))
    whole = np.vstack([before, filled, after])
    whole_speeds = np.concatenate(
        [np.full(_BEYOND, speeds[0]), speeds, np.full(_BEYOND, speeds[-1])]
    )
    numbers = np.arange(begin - _BEYOND, end + _BEYOND + 1)
    # It was not where the recorded car was, whatever it did before and after its labels.
    clear = _clear(each, whole, numbers, ego)
    low = _BEYOND - _run(clear[:_BEYOND][::-1])
    high = _BEYOND + len(filled) - 1 + _run(clear[_BEYOND + len(filled) :])
    # Into the time of the window.
    low = max(low, first - int(numbers[0]))
    high = min(high, first + _STEPS - int(numbers[0]))
    steps = np.clip(np.arange(_STEPS + 1) + first - int(numbers[0]), low, max(high, low))
    begins = int(numbers[low]) - first
    return _track(each, whole[steps], whole_speeds[steps], begins, begins + max(high - low, 0))


def _driven_on(pose: Floats, speed: float) -> Floats:
    """Poses of `_BEYOND` steps at a speed along the heading."""
    way = speed * STEP * np.arange(1, _BEYOND + 1)
    return np.column_stack(
        [
            pose[0] + way * np.cos(pose[2]),
            pose[1] + way * np.sin(pose[2]),
            np.full(_BEYOND, pose[2]),
        ]
    )


def _clear(
    each: RecordedObject, poses: Floats, frames: NDArray[np.int64], ego: Floats
) -> NDArray[np.bool_]:
    """Whether an object does not touch the recorded car, at each of some frames."""
    there = (frames >= 0) & (frames < len(ego))
    clear = np.ones(len(frames), bool)
    own = rectangle_polygons(ego[frames[there]], BMW_320I.length + 0.6, BMW_320I.width + 0.6)
    other = rectangle_polygons(poses[there], each.dimensions[2], each.dimensions[1])
    clear[there] = [not a.intersects(b) for a, b in zip(own, other, strict=True)]
    return clear


def _run(values: NDArray[np.bool_]) -> int:
    """How many values are true from the first on."""
    return len(values) if values.all() else int(np.argmin(values))


def _track(each: RecordedObject, poses: Floats, speeds: Floats, first: int, last: int) -> Tracks:
    return Tracks(
        ids=np.array([each.id], np.int64),
        categories=np.array([each.category], np.str_),
        dimensions=each.dimensions[None],
        poses=poses[None],
        speeds=speeds[None],
        first=np.array([first], np.int64),
        last=np.array([last], np.int64),
        below=np.array([each.below]),
    )


def _joined(rows: list[Tracks]) -> Tracks:
    if not rows:
        none = Boxes3D.empty()
        empty = np.zeros(0)
        return Tracks.at_constant_velocity(
            none.category, none.dimensions, none.poses, empty, empty, _STEPS
        )
    first = rows[0]
    return replace(
        first,
        **{
            name: np.concatenate([getattr(each, name) for each in rows])
            for name in first.__dataclass_fields__
        },
    )


def _against(tracks: Tracks, path: Floats) -> frozenset[int]:
    """The lanes beside the path in which more vehicles drive against it than along it."""
    line, balance = centre_of(path), {LEFT: 0, RIGHT: 0}
    for actor in range(len(tracks)):
        if str(tracks.categories[actor]) in _PEOPLE:
            continue
        ways = {LEFT: 0.0, RIGHT: 0.0}
        for step in range(int(tracks.first[actor]), int(tracks.last[actor]) + 1, 5):
            if tracks.speeds[actor, step] < _DRIVING:
                continue
            x, y, heading = tracks.poses[actor, step]
            along, left = line.coordinates(x, y)
            if 0.5 * LANE_WIDTH < abs(left) < 1.5 * LANE_WIDTH:
                ways[LEFT if left > 0 else RIGHT] += np.cos(heading - line.heading(along))
        for lane, way in ways.items():
            balance[lane] += int(np.sign(way))
    return frozenset(lane for lane, count in balance.items() if count < 0)
