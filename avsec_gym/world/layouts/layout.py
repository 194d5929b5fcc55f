"""Seeded KITTI-like layouts: the embedded default data, for users without KITTI.

A layout is a labelled scene without images.  Its world is drawn first (a road, rows of parked,
standing and moving objects, people), then cut down to what a KITTI camera sees and an annotator
labels.  Same seed, same layout, bit for bit.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from avsec_gym.argument_checks import whole_number
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, ego_to_camera
from avsec_gym.road_type import RoadType
from avsec_gym.world.layouts.dimensions import CATEGORIES, Codes
from avsec_gym.world.layouts.highway import highway
from avsec_gym.world.layouts.road import LayoutRoad, Placed
from avsec_gym.world.layouts.street import street
from avsec_gym.world.layouts.view import (
    covered_shares,
    observation_angle,
    project_boxes,
    without_overlaps,
)

MOST_LAYOUTS = 100_000
"""Most layouts of a set that is made at once: these take some minutes and 400 MB."""
HIGHWAY_SHARE = 168 / 600
"""Highway share of the layouts whose road type is left open, as in the labelled driving-safety
scenarios."""

_CAMERA_HEIGHT = 1.65
_EGO_SIZE = (5.0, 2.3)
_CLEARANCE = 0.1
_SMALLEST_IN_IMAGE = (6.0, 14.0)
_LARGEST_TRUNCATION = 0.997
_OCCLUSION_STEPS = (0.15, 0.60)
_HIDDEN = 0.6
_CLUTTER = 0.20
_CLUTTER_FROM = 10.0
_UNKNOWN_OCCLUSION = np.array([0.025, 0.17, 0.16, 0.09, 0.01, 0.16])


@dataclass(frozen=True, eq=False)
class SceneLayout:
    """One labelled scene as the ego vehicle meets it."""

    id: str
    """Road type and number, such as ``street-000123``; `layout_by_id` makes it again."""
    road_type: RoadType
    boxes: Boxes3D
    """Labels from near to far; every optional column is there."""
    road: LayoutRoad
    """The road's course and lanes."""
    ground: tuple[float, float, float]
    """Plane on which all objects stand, in the camera frame: ``y = g[0] + g[1] x + g[2] z``;
    ``g[0]`` is the camera's height in metres."""
    set_seed: int
    index: int
    """The layout is number `index` of the set with seed `set_seed`."""


def generate_layout(
    seed: int, road_type: RoadType | None = None, *, set_seed: int = 0
) -> SceneLayout:
    """Make one layout: number `seed` of the set with seed 0, or of another set.

    Args:
        seed: Number of the layout, 0 or more.
        road_type: STREET, HIGHWAY, or None to draw it (72 % streets).
        set_seed: Seed of the set, 0 or more.

    Returns:
        The same layout for the same arguments in every process.

    Raises:
        ConfigurationError: The seed is negative.

    Example:
        >>> layout = generate_layout(123, RoadType.STREET)
        >>> layout.id
        'street-000123'
    """
    return _layout(set_seed, seed, road_type)


def generate_layouts(
    count: int, seed: int = 0, road_type: RoadType | None = None
) -> list[SceneLayout]:
    """Make the first layouts of a set.

    Args:
        count: Number of layouts, 0 to `MOST_LAYOUTS`; layout i does not depend on it.
        seed: Seed of the set, 0 or more.  In set 0, layout i is ``generate_layout(i)``.
        road_type: STREET, HIGHWAY, or None for the mix of the labelled scenarios.

    Raises:
        ConfigurationError: A negative seed, or another count.
    """
    whole_number("count", count, 0, MOST_LAYOUTS)
    return [_layout(seed, index, road_type) for index in range(count)]


def layout_by_id(layout_id: str) -> SceneLayout:
    """Make the layout that bears this id again.

    Raises:
        ConfigurationError: Not the id of a layout.

    Example:
        >>> layout_by_id("highway-000007").road_type
        <RoadType.HIGHWAY: 'highway'>
    """
    match = re.fullmatch(r"(street|highway)-(?:s(\d+)-)?(\d{6,})", layout_id)
    if match is None:
        raise ConfigurationError(
            f"{layout_id!r} is no layout; ids look like 'street-000123', "
            "or 'highway-s7-000123' in the set with seed 7"
        )
    return _layout(int(match[2] or 0), int(match[3]), RoadType(match[1]))


def _layout(seed: int, index: int, road_type: RoadType | None) -> SceneLayout:
    if seed < 0 or index < 0:
        raise ConfigurationError(f"seeds of layouts are 0 or more, got {min(seed, index)}")
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence((seed, index))))
    drawn = RoadType.HIGHWAY if rng.random() < HIGHWAY_SHARE else RoadType.STREET
    kind = drawn if road_type is None else RoadType(road_type)
    height, roll, pitch = rng.standard_normal(3)
    ground = (
        _CAMERA_HEIGHT + 0.05 * float(height),
        -0.012 + 0.012 * float(roll),
        0.006 * float(pitch),
    )
    road, placed = highway(rng) if kind is RoadType.HIGHWAY else street(rng)
    name = f"{index:06d}" if seed == 0 else f"s{seed}-{index:06d}"
    boxes = _labels(rng, road, placed, ground)
    return SceneLayout(f"{kind.value}-{name}", kind, boxes, road, ground, seed, index)


def _labels(
    rng: np.random.Generator, road: LayoutRoad, placed: Placed, ground: tuple[float, float, float]
) -> Boxes3D:
    """Everything that the camera sees and that does not collide, from near to far."""
    poses = road.poses(placed.along, placed.left, placed.heading)
    near_view = (poses[:, 0] > -9.0) & (np.abs(poses[:, 1]) < poses[:, 0] + 18.0)
    placed, poses = placed.pick(near_view), poses[near_view]
    location, rotation_y = ego_to_camera(poses, 0.0)
    location[:, 1] = ground[0] + ground[1] * location[:, 0] + ground[2] * location[:, 2]
    box2d, truncation = project_boxes(location, placed.dimensions, rotation_y)
    size = box2d[:, 2:] - box2d[:, :2]
    seen = np.flatnonzero((size > _SMALLEST_IN_IMAGE).all(1) & (truncation < _LARGEST_TRUNCATION))

    with_ego = np.concatenate([np.zeros((1, 3)), poses[seen]])
    length, width = placed.dimensions[seen, 2], placed.dimensions[seen, 1]
    free = without_overlaps(
        with_ego,
        np.concatenate([_EGO_SIZE[:1], length + _CLEARANCE]),
        np.concatenate([_EGO_SIZE[1:], width + _CLEARANCE]),
    )
    kept = seen[free[1:]]
    distance = np.hypot(location[kept, 0], location[kept, 2])
    order = np.argsort(distance, kind="stable")
    kept, distance = kept[order], distance[order]
    covered = covered_shares(box2d[kept])
    occlusion = _occlusion_levels(rng, covered, distance, placed.codes[kept])
    visible = covered < _HIDDEN + (1.0 - _HIDDEN) * rng.random(len(covered))
    kept = kept[visible]
    return Boxes3D(
        location=location[kept],
        dimensions=placed.dimensions[kept],
        rotation_y=rotation_y[kept],
        score=np.ones(len(kept)),
        category=CATEGORIES[placed.codes[kept]],
        box2d=box2d[kept],
        truncation=truncation[kept],
        occlusion=occlusion[visible],
        alpha=observation_angle(location[kept], rotation_y[kept]),
        moving=placed.moving[kept],
    )


def _occlusion_levels(
    rng: np.random.Generator, covered: Floats, distance: Floats, codes: Codes
) -> Floats:
    """KITTI's levels from the covered share, with what no label holds: clutter and unknowns.

    In KITTI one in five objects that no other labelled object covers is still partly occluded,
    by walls, trees and poles, and some levels are unknown (3).
    """
    level = np.searchsorted(_OCCLUSION_STEPS, covered).astype(float)
    chance, unknown = rng.random((2, len(covered)))
    cluttered = (level == 0.0) & (distance > _CLUTTER_FROM) & (chance < _CLUTTER)
    level[cluttered] = np.where(chance[cluttered] < 0.15 * _CLUTTER, 2.0, 1.0)
    level[unknown < _UNKNOWN_OCCLUSION[codes]] = 3.0
    return level
