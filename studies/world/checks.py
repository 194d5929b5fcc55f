"""What must not be seen in a rendered world.

Floating, sunk or interpenetrating things, shadows that begin away from their objects, a road that
misses the horizon, a texture that repeats.

Run ``python -m studies.world.checks --frames 50``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, rectangle_polygons, transform_points
from avsec_gym.world.built_scene import actor_mesh
from avsec_gym.world.capture import Capture, Float32s, pinhole
from avsec_gym.world.drives import Actors
from avsec_gym.world.posed_scenes import PosedScene
from avsec_gym.world.rendering.ray_scene import Hits, RayScene
from avsec_gym.world.site import Surface
from studies.world.command import command, measure_one
from studies.world.tiling import LARGEST_REPEAT, texture_repeat

LARGEST_GAP = 0.03
"""Metres between the middle of an actor's bottom and the ground."""
DEEPEST_FOOT, HIGHEST_FOOT = -0.05, 0.05
"""Metres that any of an actor's lowest points may be below or above the ground."""
LARGEST_OVERLAP = 0.02
"""Square metres that two footprints may share."""
_BESIDE, _LOWEST = 0.015, 0.01
_MARGIN = 0.06
_GROUND = (Surface.ROAD, Surface.PARKING, Surface.CYCLE_PATH, Surface.PAVEMENT)


@dataclass(frozen=True)
class SceneChecks:
    """All checks of one scene."""

    gaps: list[float]
    """Gaps between the bottoms of actors and the ground at their middles, metres."""
    feet: list[list[float]]
    """The smallest and the largest gap of the points where each actor stands, metres."""
    overlaps: list[list[int]]
    """Pairs of actors that share ground."""
    pierced: list[int]
    """Actors with scenery inside."""
    contact: list[float]
    """The share, for each actor in the sun, of its contact points whose shadow begins at them."""
    repeat: float | None
    """See `texture_repeat`."""
    horizon: float | None
    """The error of the horizon, pixels; see `horizon_error`."""


@dataclass(frozen=True)
class FailingFrames:
    """The frames that fail a check, by number."""

    gaps: list[int]
    feet: list[int]
    overlaps: list[int]
    pierced: list[int]


@dataclass(frozen=True)
class Checked:
    """How many things fail each check, and the worst of each; see `SceneChecks`."""

    frames: int
    actors: int
    floating: int
    sunk: int
    feet_in_the_ground: int
    feet_in_the_air: int
    overlapping_pairs: int
    pierced: int
    contact_shadows: float | None
    """The share of actors in the sun whose shadow begins where they stand."""
    contact_shadow_median: float | None
    largest_repeat: float | None
    repeating: int
    horizon_error: float | None
    largest_horizon_error: float | None
    by_frame: FailingFrames


def measure(posed: PosedScene, capture: Capture) -> SceneChecks:
    """All checks of one scene."""
    actors = posed.instant.actors
    bare = posed.built.renderer(actors.pick(np.array([0])), 0)
    others = range(1, len(actors))
    return SceneChecks(
        gaps=[round(ground_gap(bare.scene, actors, index), 4) for index in others],
        feet=[feet_gaps(bare.scene, actors, index) for index in others],
        overlaps=overlapping(actors),
        pierced=[index for index in others if is_pierced(bare.scene, actors, index)],
        contact=contact_shadows(posed),
        repeat=texture_repeat(bare, posed),
        horizon=horizon_error(posed, capture),
    )


def ground_gap(scene: RayScene, actors: Actors, index: int) -> float:
    """How far an actor's bottom is above what lies below its middle, metres; 99 over nothing."""
    x, y, _ = actors.pose[index]
    start = np.array([[x, y, actors.z[index] + 0.5]])
    down = scene.hits(*_rays(start, np.array([0.0, 0.0, -1.0])))
    return float(down.distance[0] - 0.5) if down.face[0] >= 0 else 99.0


def feet_gaps(scene: RayScene, actors: Actors, index: int) -> list[float]:
    """The smallest and the largest gap below an actor's lowest points, metres."""
    feet = _feet(actors, index)
    down = scene.hits(*_rays(feet + np.array([0.0, 0.0, 0.5]), np.array([0.0, 0.0, -1.0])))
    gaps = np.where(down.face >= 0, down.distance - 0.5, 99.0)
    return [round(float(gaps.min()), 4), round(float(gaps.max()), 4)]


def _feet(actors: Actors, index: int) -> Floats:
    """An actor's lowest vertices in the world, shape (n, 3)."""
    x, y, heading = actors.pose[index].tolist()
    mesh = actor_mesh(actors, index).placed(x, y, float(actors.z[index]), heading)
    vertices = mesh.vertices.astype(float)
    return vertices[vertices[:, 2] < vertices[:, 2].min() + _LOWEST]


def overlapping(actors: Actors) -> list[list[int]]:
    """Pairs of actors that stand in one another."""
    size = actors.dimensions
    shapes = rectangle_polygons(actors.pose, size[:, 2], size[:, 1])
    tree = shapely.STRtree(shapes)
    first, second = tree.query(shapes, predicate="intersects")
    pairs = (first < second) & (
        shapely.area(shapely.intersection(shapes[first], shapes[second])) > LARGEST_OVERLAP
    )
    return np.stack([first[pairs], second[pairs]], axis=-1).tolist()


def is_pierced(scene: RayScene, actors: Actors, index: int) -> bool:
    """Whether scenery reaches into an actor: rays across its box at three heights meet it."""
    height, width, length = actors.dimensions[index]
    x, y, heading = actors.pose[index]
    cos, sin = np.cos(heading), np.sin(heading)
    forward, left = np.array([cos, sin, 0.0]), np.array([-sin, cos, 0.0])
    levels = actors.z[index] + height * np.array([0.3, 0.6, 0.9])
    for direction, extent, side, spread in (
        (forward, length, left, width),
        (left, width, forward, length),
    ):
        for offset in np.array([-0.4, 0.0, 0.4]) * spread:
            begin = (x, y, 0.0) + side * offset - direction * (0.5 * extent - _MARGIN)
            starts = begin + np.array([[0.0, 0.0, level] for level in levels])
            hits = scene.hits(*_rays(starts, direction))
            near = (hits.face >= 0) & (hits.distance < extent - 2 * _MARGIN)
            if (near & _is_solid(scene, hits)).any():
                return True
    return False


def contact_shadows(posed: PosedScene) -> list[float]:
    """The share of its lowest points at which its shadow begins, of each actor in the sun.

    A little beside the points where it stands, away from the sun, it must be dark: below a thing
    that floats it is not.
    """
    actors, light = posed.instant.actors, posed.built.light
    if light.cloudiness > 0.9:
        return []
    scene = posed.built.scene(actors, 0)
    away = -light.sun[:2] / np.linalg.norm(light.sun[:2])
    shares = []
    for index in range(1, len(actors)):
        x, y, _ = actors.pose[index]
        top = np.array([[x, y, actors.z[index] + actors.dimensions[index, 0] + 0.05]])
        if scene.blocked(*_rays(top, light.sun)).any():
            continue
        feet = _feet(actors, index)
        beside = feet + np.array([*(away * _BESIDE), 0.0])
        beside[:, 2] = actors.z[index] + 0.005
        shares.append(round(float(scene.blocked(*_rays(beside, light.sun)).mean()), 3))
    return shares


def horizon_error(posed: PosedScene, capture: Capture) -> float | None:
    """Median distance of the road's pixels beyond 40 m from where they should be, in pixels.

    Each is looked for on the ground below its place in the world, and projected again.
    """
    camera = pinhole(posed.rig, posed.rig.stereo_pair[0], posed.vehicle_to_world[0])
    depth = capture.geometry.depth
    v, u = np.nonzero((capture.geometry.surface == Surface.ROAD) & (depth > 40.0))
    if len(v) < 20:
        return None
    far = depth[v, u]
    rays = np.stack([u - camera.centre[0], v - camera.centre[1]], axis=-1) / camera.focal_length
    places = transform_points(
        camera.to_world, np.column_stack([rays * far[:, None], far]).astype(float)
    )
    places[:, 2] = posed.site.ground.height(places[:, 0], places[:, 1])
    back = transform_points(np.linalg.inv(camera.to_world), places)
    rows = camera.focal_length * back[:, 1] / back[:, 2] + camera.centre[1]
    return round(float(np.median(np.abs(rows - v))), 3)


def _is_solid(scene: RayScene, hits: Hits) -> NDArray[np.bool_]:
    return ~np.isin(scene.surface[np.maximum(hits.face, 0)], (*_GROUND, Surface.KERB))


def _rays(starts: Floats, direction: Floats | Float32s) -> tuple[Float32s, Float32s]:
    origins = np.ascontiguousarray(starts, np.float32)
    directions = np.ascontiguousarray(np.broadcast_to(direction, origins.shape), np.float32)
    return origins, directions


def summary(rows: Sequence[SceneChecks]) -> Checked:
    """How many things fail each check, and the worst of each.

    Args:
        rows: The rows of `measure`.
    """
    gaps = np.array([gap for row in rows for gap in row.gaps])
    feet = np.array([pair for row in rows for pair in row.feet]).reshape(-1, 2)
    contact = np.array([share for row in rows for share in row.contact])
    repeat = np.array([row.repeat for row in rows if row.repeat is not None])
    horizon = np.array([row.horizon for row in rows if row.horizon is not None])
    return Checked(
        frames=len(rows),
        actors=len(gaps),
        floating=int((gaps > LARGEST_GAP).sum()),
        sunk=int((gaps < -LARGEST_GAP).sum()),
        feet_in_the_ground=int((feet[:, 0] < DEEPEST_FOOT).sum()),
        feet_in_the_air=int((feet[:, 1] > HIGHEST_FOOT).sum()),
        overlapping_pairs=sum(len(row.overlaps) for row in rows),
        pierced=sum(len(row.pierced) for row in rows),
        contact_shadows=_share_above(contact, 0.9),
        contact_shadow_median=float(np.median(contact)) if len(contact) else None,
        largest_repeat=float(repeat.max()) if len(repeat) else None,
        repeating=int((repeat > LARGEST_REPEAT).sum()),
        horizon_error=float(np.median(horizon)) if len(horizon) else None,
        largest_horizon_error=float(horizon.max()) if len(horizon) else None,
        by_frame=FailingFrames(
            gaps=_frames(rows, lambda row: any(abs(gap) > LARGEST_GAP for gap in row.gaps)),
            feet=_frames(
                rows,
                lambda row: any(
                    low < DEEPEST_FOOT or high > HIGHEST_FOOT for low, high in row.feet
                ),
            ),
            overlaps=_frames(rows, lambda row: bool(row.overlaps)),
            pierced=_frames(rows, lambda row: bool(row.pierced)),
        ),
    )


def _share_above(values: Floats, bound: float) -> float | None:
    return float((values > bound).mean()) if len(values) else None


def _frames(rows: Sequence[SceneChecks], fails: Callable[[SceneChecks], bool]) -> list[int]:
    return [number for number, row in enumerate(rows) if fails(row)]


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write JSON; returns the exit code."""
    return command(
        __doc__,
        arguments,
        lambda options: summary(measure_one(options, measure, images=False)),
        frames=50,
    )


if __name__ == "__main__":
    sys.exit(main())
