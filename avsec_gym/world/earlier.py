"""The frames just before a posed scene, for tasks that use a frame and its predecessors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.road_type import RoadType
from avsec_gym.world.actors import Actors
from avsec_gym.world.framing import lifted
from avsec_gym.world.models.people import METRES_PER_CRANK, stride_length
from avsec_gym.world.posed_scenes import PosedScene

_SPEEDS = {RoadType.STREET: (5.0, 9.0), RoadType.HIGHWAY: (10.0, 14.0)}
_HEADWAY, _STANDSTILL, _LANE = 1.5, 3.0, 1.3


def earlier(posed: PosedScene, seconds: float, ego_speed: float) -> PosedScene:
    """The same scene a little before, every actor at constant velocity.

    Actors move along their headings, the ego vehicle along the road.

    Args:
        posed: The scene, with one ego vehicle; its built scene stays.
        seconds: Time by which the result is earlier, seconds.
        ego_speed: Speed of the ego vehicle, m/s.
    """
    actors, own = posed.instant.actors, posed.instant.egos[0]
    way = actors.speed * seconds
    heading = actors.pose[:, 2]
    pose = actors.pose.copy()
    pose[:, 0] -= way * np.cos(heading)
    pose[:, 1] -= way * np.sin(heading)
    now = posed.vehicle_to_world[0]
    then = _back_along_road(posed, now, ego_speed * seconds)
    turn = then[:3, :3] @ now[:3, :3].T
    pose[own, :2] = then[:2, 3]
    pose[own, 2] += np.arctan2(turn[1, 0], turn[0, 0])
    before = replace(actors, pose=pose, phase=_phase_before(actors, way))
    rise = _ground_below(posed, before) - _ground_below(posed, actors)
    instant = replace(
        posed.instant, time=posed.instant.time - seconds, actors=replace(before, z=actors.z + rise)
    )
    seed = (*posed.seed, round(1000 * seconds))
    return replace(posed, instant=instant, vehicle_to_world=then[None], seed=seed)


def plausible_ego_speed(posed: PosedScene) -> float:
    """A usual speed for the road, m/s, lower behind an actor close ahead in the same lane."""
    actors, own = posed.instant.actors, posed.instant.egos[0]
    along, left = posed.site.course.coordinates(actors.pose[:, 0], actors.pose[:, 1])
    ahead, aside = along - along[own], np.abs(left - left[own])
    others = (ahead > 1.0) & (aside < _LANE)
    half = 0.5 * (actors.dimensions[:, 2] + actors.dimensions[own, 2])
    gap = float((ahead - half)[others].min(initial=np.inf))
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence((*posed.seed, 6))))
    wanted = float(rng.uniform(*_SPEEDS[posed.site.road_type]))
    return min(wanted, max(gap - _STANDSTILL, 0.0) / _HEADWAY)


def _back_along_road(posed: PosedScene, now: Floats, way: float) -> Floats:
    """The vehicle's pose `way` metres before, at the same distance from the road's line."""
    course, ground = posed.site.course, posed.site.ground
    x, y = float(now[0, 3]), float(now[1, 3])
    along, left = (float(value) for value in course.coordinates(x, y))
    here, there = course.poses([along, along - way], left)
    turn = there[2] - here[2]
    then = np.eye(4)
    cos, sin = np.cos(turn), np.sin(turn)
    then[:3, :3] = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ now[:3, :3]
    then[:2, 3] = now[:2, 3] + there[:2] - here[:2]
    rise = ground.height(then[0, 3], then[1, 3]) - ground.height(x, y)
    then[2, 3] = now[2, 3] + float(rise)
    return then


def _ground_below(posed: PosedScene, actors: Actors) -> Floats:
    level = posed.site.ground.height(actors.pose[:, 0], actors.pose[:, 1])
    return level + lifted(actors, posed.site.course, posed.site.section)


def _phase_before(actors: Actors, way: Floats) -> Floats:
    """Steps and pedals turned back by the way."""
    turn = np.where(
        actors.category == "Cyclist", METRES_PER_CRANK, stride_length(actors.dimensions[:, 0])
    )
    steps = np.isin(actors.category, ("Cyclist", "Pedestrian"))
    return np.where(steps, (actors.phase - way / turn) % 1.0, actors.phase)
