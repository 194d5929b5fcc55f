"""The motion of a scene's actors around one instant, and the scene a little later."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.world.actors import Instant
from avsec_gym.world.posed_scenes import PosedScene
from avsec_gym.world.rendering.moving_bodies import MovingBody
from avsec_gym.world.rendering.planar_motion import PlanarMotion

_FAR = 95.0
"""Metres from a LiDAR beyond which it matters not whether something moves."""


def with_turn_rates(instant: Instant, following: Instant) -> Instant:
    """An instant with its actors' turn rates: how far they turn until the following instant.

    Args:
        instant: The instant.
        following: A later one, in which actors may be missing (those do not turn).
    """
    now, then = instant.actors, following.actors
    turn_rate = np.zeros(len(now))
    _, here, there = np.intersect1d(now.id, then.id, return_indices=True)
    turned = wrap_angle(then.pose[there, 2] - now.pose[here, 2])
    turn_rate[here] = turned / (following.time - instant.time)
    return replace(instant, turn_rate=turn_rate)


def motion_of(instant: Instant, index: int) -> PlanarMotion:
    """How one of the actors moves."""
    turn_rate = 0.0 if instant.turn_rate is None else float(instant.turn_rate[index])
    return PlanarMotion(float(instant.actors.speed[index]), turn_rate)


def sensor_motion(instant: Instant, ego: int) -> PlanarMotion:
    """How one of the sensor vehicles moves.

    Args:
        instant: The instant.
        ego: Number of the vehicle among those of the instant.
    """
    return motion_of(instant, instant.egos[ego])


def moving_bodies(instant: Instant, ego: int) -> list[MovingBody]:
    """All actors that move near one of the sensor vehicles, but that vehicle itself.

    Args:
        instant: The instant; actor i has the object id i.
        ego: Number of the vehicle among those of the instant.
    """
    own = instant.egos[ego]
    near = bodies_near(instant, *instant.actors.pose[own, :2].tolist())
    return [body for body in near if body.object_id != own]


def bodies_near(instant: Instant, x: float, y: float) -> list[MovingBody]:
    """All actors that move near a place in the world, metres; see `moving_bodies`."""
    away = instant.actors.pose[:, :2] - (x, y)
    near = np.hypot(*away.T) < _FAR
    return [
        MovingBody(index, tuple(instant.actors.pose[index].tolist()), motion)
        for index in np.flatnonzero(near).tolist()
        if not (motion := motion_of(instant, index)).stands
    ]


def poses_after(instant: Instant, seconds: float) -> Floats:
    """Positions x, y and headings of all actors a little later or earlier, shape (N, 3).

    Args:
        instant: The instant.
        seconds: Time that passes, negative for the past; actors keep speed and turn rate.
    """
    poses = instant.actors.pose.copy()
    for index in range(len(poses)):
        ahead, left, turned = motion_of(instant, index).after(seconds)
        cos, sin = np.cos(poses[index, 2]), np.sin(poses[index, 2])
        poses[index] += (ahead * cos - left * sin, ahead * sin + left * cos, turned)
    return poses


def later(posed: PosedScene, seconds: float) -> PosedScene:
    """A posed scene a little later or earlier: all actors and sensor vehicles have moved on.

    Args:
        posed: The scene.
        seconds: Time that passes, at most some tenths of a second; negative for the past.
    """
    if seconds == 0.0:
        return posed
    instant, ground = posed.instant, posed.site.ground
    pose = poses_after(instant, seconds)
    before = instant.actors.pose
    rise = ground.height(pose[:, 0], pose[:, 1]) - ground.height(before[:, 0], before[:, 1])
    actors = replace(instant.actors, pose=pose, z=instant.actors.z + rise)
    moved = [
        sensor_motion(instant, ego).transforms(np.array([seconds]))[0]
        for ego in range(len(instant.egos))
    ]
    return replace(
        posed,
        instant=replace(instant, time=instant.time + seconds, actors=actors),
        vehicle_to_world=posed.vehicle_to_world @ np.stack(moved),
    )


def with_ego_speed(posed: PosedScene, speed: float) -> PosedScene:
    """The same scene, in which the first sensor vehicle drives at a speed (m/s)."""
    speeds = posed.instant.actors.speed.copy()
    speeds[posed.instant.egos[0]] = speed
    actors = replace(posed.instant.actors, speed=speeds)
    return replace(posed, instant=replace(posed.instant, actors=actors))
