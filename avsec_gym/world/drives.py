"""Drives: the same place and traffic over time, as one or several sensor vehicles see them."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import overload

import numpy as np
import shapely

from avsec_gym.geometry import Floats, rectangle_polygons
from avsec_gym.rig import SensorRig, kitti_rig
from avsec_gym.world.actors import Actors, Instant
from avsec_gym.world.assets import Assets
from avsec_gym.world.built_scene import BuiltScene, build_scene
from avsec_gym.world.ground import Ground
from avsec_gym.world.motion import with_turn_rates
from avsec_gym.world.posed_scenes import PosedScene
from avsec_gym.world.rendering.light import draw_light
from avsec_gym.world.site import Site, Style
from avsec_gym.world.sites import draw_site
from avsec_gym.world.traffic import simulate
from avsec_gym.world.traffic.egos import EGO_SPACING

__all__ = [
    "MOST_DRIVE_FRAMES",
    "STEP",
    "Actors",
    "DriveScenes",
    "DriveWorld",
    "Instant",
    "drive_scenes",
    "vehicle_poses",
]

STEP = 0.1
"""Seconds between frames."""
MOST_DRIVE_FRAMES = 10_000
"""Most drive frames of a drive: KITTI's longest has 5,177."""

_BEFORE, _BEYOND = 80.0, 260.0
"""Metres of road before the ego vehicle's first place and beyond its last."""
_BEHIND, _AHEAD = 90.0, 210.0
"""Metres of road built behind the rearmost and ahead of the foremost ego vehicle."""
_STYLES = {
    Style.RESIDENTIAL: 14.0,
    Style.CITY: 16.0,
    Style.HIGHWAY: 40.0,
    Style.RURAL: 30.0,
    Style.CAMPUS: 12.0,
}
"""Styles in the order in which the drives of a set use them, and the largest speed there, m/s."""
_WHEELBASE, _TRACK = 2.7, 1.55
_ROOM = 0.4
"""Metres left free around every actor."""
_SEED = 7


class DriveScenes(Sequence[PosedScene]):
    """The posed scenes of a drive, 10 each second, made when asked for.

    Args:
        world: Place and traffic.
        rig: The sensors that every ego vehicle carries.
    """

    def __init__(self, world: DriveWorld, rig: SensorRig) -> None:
        self.world, self.rig = world, rig

    def __len__(self) -> int:
        return len(self.world.instants)

    @overload
    def __getitem__(self, index: int) -> PosedScene: ...
    @overload
    def __getitem__(self, index: slice) -> list[PosedScene]: ...
    def __getitem__(self, index: int | slice) -> PosedScene | list[PosedScene]:
        """One posed scene, or several."""
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        number = range(len(self))[index]
        world = self.world
        return PosedScene(
            site=world.site,
            built=world.built,
            instant=world.turning(number),
            rig=self.rig,
            vehicle_to_world=world.ego_poses[number],
            seed=(*world.seed, number),
        )


@dataclass(frozen=True, eq=False)
class DriveWorld:
    """Place and traffic of a drive; the place is built up when it is first rendered."""

    site: Site
    instants: tuple[Instant, ...]
    seed: tuple[int, int, int]

    after: Instant
    """The instant that follows the last one: actors turn towards it."""

    def turning(self, number: int) -> Instant:
        """An instant, with the turn rates of its actors."""
        following = (*self.instants, self.after)[number + 1]
        return with_turn_rates(self.instants[number], following)

    @cached_property
    def ego_poses(self) -> Floats:
        """From each ego vehicle's frame to the world at each instant, shape (T, E, 4, 4)."""
        egos = [instant.actors.pose[list(instant.egos)] for instant in self.instants]
        return vehicle_poses(self.site.ground, np.stack(egos))

    @cached_property
    def built(self) -> BuiltScene:
        """The place built up and lit."""
        rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence((*self.seed, 1))))
        places = self.ego_poses[..., :2, 3].reshape(-1, 2)
        along, _ = self.site.course.coordinates(places[:, 0], places[:, 1])
        course = self.site.course
        start = max(float(along.min()) - _BEHIND, course.start)
        end = min(float(along.max()) + _AHEAD, course.end)
        return build_scene(self.site, draw_light(rng), start, end, _free_areas(self.instants))


def drive_scenes(
    seed: int,
    index: int,
    frames: int,
    egos: int = 1,
    rig: SensorRig | None = None,
    spacing: tuple[float, float] = EGO_SPACING,
    assets: Assets = Assets.ALL,
) -> DriveScenes:
    """The posed scenes of a drive; same arguments, same drive.

    Args:
        seed: Seed of the set of drives.
        index: Number of the drive in the set; styles of places follow each other.
        frames: Number of frames, 0.1 s apart.
        egos: Number of vehicles with sensors.
        rig: The sensors that they carry; KITTI's if None.
        spacing: Least and greatest distance of the others from the first of them, metres.
        assets: The part of the assets that place and actors are made of.
    """
    world = _drive_world(seed, index, frames, egos, spacing, assets)
    return DriveScenes(world, rig or kitti_rig())


def vehicle_poses(ground: Ground, poses: Floats) -> Floats:
    """Poses of vehicles whose wheels stand on the ground.

    Args:
        ground: The land.
        poses: Position x, y and heading of the body's centre, shape (..., 3).

    Returns:
        From the vehicle frame (x forward, y left, z up) to the world, shape (..., 4, 4).
    """
    x, y, heading = np.moveaxis(np.asarray(poses, float), -1, 0)
    cos, sin = np.cos(heading), np.sin(heading)

    def slope(east: Floats, north: Floats, reach: float) -> Floats:
        east, north = 0.5 * reach * east, 0.5 * reach * north
        rise = ground.height(x + east, y + north) - ground.height(x - east, y - north)
        return np.asarray(rise / reach)

    forward = np.stack([cos, sin, slope(cos, sin, _WHEELBASE)], axis=-1)
    left = np.stack([-sin, cos, slope(-sin, cos, _TRACK)], axis=-1)
    up = np.cross(forward, left)
    forward /= np.linalg.norm(forward, axis=-1, keepdims=True)
    up /= np.linalg.norm(up, axis=-1, keepdims=True)
    place = np.stack([x, y, ground.height(x, y)], axis=-1)
    result = np.zeros((*x.shape, 4, 4))
    result[..., :3, :] = np.stack([forward, np.cross(up, forward), up, place], axis=-1)
    result[..., 3, 3] = 1.0
    return result


@functools.lru_cache(maxsize=1)
def _drive_world(
    seed: int, index: int, frames: int, egos: int, spacing: tuple[float, float], assets: Assets
) -> DriveWorld:
    """Kept for the next frame: a worker goes through a drive in order."""
    numbers = (seed, index, _SEED)
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(numbers)))
    style = list(_STYLES)[(seed + index) % len(_STYLES)]
    duration = STEP * (frames - 1)
    length = _BEFORE + _STYLES[style] * duration + _BEYOND
    site = draw_site(style, rng, length=length, assets=assets)
    simulated = simulate(site, rng, duration=duration + STEP, step=STEP, egos=egos, spacing=spacing)
    *instants, after = (replace(each, actors=each.actors.of_part(assets)) for each in simulated)
    return DriveWorld(site, tuple(instants), numbers, after)


def _free_areas(instants: Sequence[Instant]) -> list[shapely.Geometry]:
    """The area that each actor covers over the whole drive."""
    actors = [instant.actors for instant in instants]
    rows = np.concatenate(
        [np.column_stack([each.id, each.pose, each.dimensions[:, 1:]]) for each in actors]
    )
    rows = np.unique(rows, axis=0)  # A standing actor has one footprint for the drive.
    size = rows[:, 4:] + 2.0 * _ROOM
    footprints = rectangle_polygons(rows[:, 1:4], size[:, 1], size[:, 0])
    return [shapely.union_all(footprints[rows[:, 0] == id]) for id in np.unique(rows[:, 0])]
