"""Posed scenes: a built scene with the actors of one instant and the pose of the sensors."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats
from avsec_gym.rig import SensorRig, kitti_rig
from avsec_gym.road_type import RoadType
from avsec_gym.world.actors import Actors, Instant
from avsec_gym.world.assets import Assets, seed_of
from avsec_gym.world.built_scene import BuiltScene, build_scene
from avsec_gym.world.course import Course, course_from_curvature
from avsec_gym.world.framing import (
    actors_from_boxes,
    ground_through,
    highway_lanes,
    keep_clear,
    levelled,
    lifted,
    parked_beside,
    usual_heading,
    with_dropped_kerbs,
    with_street_behind,
)
from avsec_gym.world.ground import Ground
from avsec_gym.world.layouts import SceneLayout
from avsec_gym.world.layouts.road import LayoutRoad
from avsec_gym.world.rendering.light import draw_light
from avsec_gym.world.road.sections import section_for_lanes
from avsec_gym.world.site import Site, Style

BEHIND, AHEAD = -60.0, 190.0
"""Metres of road built behind and ahead of the ego vehicle for a single frame."""
PAINTED = (-15.0, 160.0)
"""Metres of it with markings and wear: as far as a camera resolves them."""
_LAST_BEHIND = 8.0
"""Metres of the road's beginning without actors."""

_SPEEDS = {RoadType.STREET: (6.0, 8.0), RoadType.HIGHWAY: (11.0, 13.0)}
_STREET_STYLES = {
    Style.CITY: 0.36,
    Style.RESIDENTIAL: 0.42,
    Style.CAMPUS: 0.12,
    Style.RURAL: 0.10,
}


@dataclass(frozen=True, eq=False)
class PosedScene:
    """A scene that is ready to be rendered.

    Args:
        site: The place.
        built: The place built up and lit.
        instant: The actors and their poses.
        rig: The sensors of every ego vehicle.
        vehicle_to_world: Pose of the rig's vehicle frame for each ego vehicle, shape (E, 4, 4).
        seed: Seed of the sensors' noise.
    """

    site: Site
    built: BuiltScene
    instant: Instant
    rig: SensorRig
    vehicle_to_world: Floats
    seed: tuple[int, ...]


def posed_scene_of_layout(
    layout: SceneLayout, rig: SensorRig | None = None, assets: Assets = Assets.ALL
) -> PosedScene:
    """The scene that belongs to one of our layouts: same seed, same scene.

    Objects on raised ground (pavements) are lifted onto it.

    Args:
        layout: The objects and the road.
        rig: The sensors of the vehicle that looks; KITTI's if None.
        assets: The part of the assets that place and actors are made of.
    """
    rig = rig or kitti_rig()
    seed = (layout.set_seed, layout.index, 3)
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))
    style = _style(layout.road_type, layout.boxes, rng)
    low, high = _SPEEDS[layout.road_type]
    speed = rng.uniform(low, high, len(layout.boxes))
    people = np.isin(layout.boxes.category, ("Pedestrian", "Person_sitting"))
    speed[people] = rng.uniform(0.8, 1.8, int(people.sum()))
    cyclists = layout.boxes.category == "Cyclist"
    speed[cyclists] = rng.uniform(3.0, 6.0, int(cyclists.sum()))
    actors = actors_from_boxes(layout.boxes, rig, speed, rng)
    height, slope_right, slope_ahead = layout.ground
    ground = Ground((rig.camera_height - height, -slope_ahead, slope_right))
    lanes = layout.road.lane_offsets
    in_sight = np.concatenate([[False], layout.boxes.occlusion == 0])
    return _posed_scene(
        actors, ground, _course(layout.road), lanes, 3.5, style, rig, in_sight, seed, rng, assets
    )


def posed_scene_of_labels(
    boxes: Boxes3D,
    rig: SensorRig,
    *,
    seed: int,
    road_type: RoadType | None = None,
    style: Style | None = None,
    assets: Assets = Assets.ALL,
) -> PosedScene:
    """A digital twin: the labelled objects exactly where they were, in a plausible place.

    Args:
        boxes: Labels of a real frame.
        rig: The sensors of the vehicle that looks, with that frame's calibration.
        seed: Seed of what labels leave open: looks, road, surroundings, light.
        road_type: Road type of the place; street if None.
        style: Style of the place; drawn to suit the objects if None.
        assets: The part of the assets that place and actors are made of.
    """
    numbers = (seed, 5)
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(numbers)))
    kind = road_type or RoadType.STREET
    style = style or _style(kind, boxes, rng)
    speed = np.full(len(boxes), float(np.mean(_SPEEDS[kind])))
    actors = actors_from_boxes(boxes, rig, speed, rng)
    heading = usual_heading(actors)
    course = _course(LayoutRoad(heading, 0.0, (0.0,)))
    lanes = _lanes(actors, course, style)
    hidden = np.zeros(len(boxes)) if boxes.occlusion is None else boxes.occlusion
    in_sight = np.concatenate([[False], hidden == 0])
    return _posed_scene(
        actors, None, course, lanes, 3.5, style, rig, in_sight, numbers, rng, assets
    )


def _posed_scene(
    actors: Actors,
    ground: Ground | None,
    course: Course,
    lanes: tuple[float, ...],
    lane_width: float,
    style: Style,
    rig: SensorRig,
    in_sight: np.ndarray,
    seed: tuple[int, ...],
    rng: np.random.Generator,
    assets: Assets,
) -> PosedScene:
    """Build the place around actors; the ground is fitted to them if None."""
    # Draw the road's cross section: lanes, kerbs and parking where the actors need them.
    if style == Style.HIGHWAY:
        lanes = highway_lanes(actors, course, lanes)
    parked = parked_beside(actors, course, lanes, lane_width)
    section = section_for_lanes(lanes, lane_width, style, rng, *parked)
    section = with_dropped_kerbs(actors, course, section)
    # Fit the ground to the heights of the labels, unless the layout has one.
    labelled = 0 if ground is not None else len(actors)
    if ground is None:
        ground = ground_through(actors, lifted(actors, course, section))
    # Fill the street behind the ego vehicle, and set all actors on the ground.
    shown = len(actors)
    actors = with_street_behind(actors, course, -BEHIND - _LAST_BEHIND).of_part(assets)
    lift = lifted(actors, course, section)
    # Labels hold heights; all other actors stand on the land.
    level = ground.height(actors.pose[:, 0], actors.pose[:, 1]) + lift
    actors = replace(actors, z=np.concatenate([actors.z[:labelled], level[labelled:]]))
    ground = levelled(ground, actors, lift)
    # Build the place; scenery keeps clear of the actors and of the lines of sight to them.
    site = Site(style, course, section, ground, seed_of(assets, int(rng.integers(2**31))))
    in_sight = np.concatenate([in_sight, np.zeros(len(actors) - shown, bool)])
    clear = keep_clear(actors, in_sight, 0.4)
    built = build_scene(site, draw_light(rng), BEHIND, AHEAD, clear, PAINTED)
    return PosedScene(site, built, Instant(0.0, actors), rig, np.eye(4)[None], seed)


def _style(road_type: RoadType, boxes: Boxes3D, rng: np.random.Generator) -> Style:
    """How a place with such objects is likely to be built up."""
    if road_type == RoadType.HIGHWAY:
        return Style.HIGHWAY
    people = int(np.isin(boxes.category, ("Pedestrian", "Cyclist", "Person_sitting")).sum())
    cars = int((boxes.category == "Car").sum())
    weights = dict(_STREET_STYLES)
    if people >= 4:
        weights |= {Style.RURAL: 0.0, Style.CITY: 0.7, Style.CAMPUS: 0.3}
    if cars >= 5:
        weights |= {Style.RURAL: 0.02, Style.CAMPUS: 0.05}
    shares = np.array(list(weights.values()))
    return list(weights)[int(rng.choice(len(shares), p=shares / shares.sum()))]


def _course(road: LayoutRoad) -> Course:
    """The layout's road; far away it runs on straight."""
    along = np.arange(BEHIND - 30.0, AHEAD + 121.0)
    fade = np.clip((130.0 - np.abs(along)) / 40.0, 0.0, 1.0)
    return course_from_curvature(
        road.curvature * fade, start=float(along[0]), pose=(0.0, 0.0, road.heading)
    )


def _lanes(actors: Actors, course: Course, style: Style) -> tuple[float, ...]:
    """The ego vehicle's lane, and others where vehicles drive or stand in line with it."""
    _, left = course.coordinates(actors.pose[:, 0], actors.pose[:, 1])
    left = left[1:]
    lanes = [0.0]
    if style != Style.HIGHWAY and not ((left > 1.2) & (left < 2.9)).any():
        lanes.append(3.3)
    return tuple(sorted(lanes))
