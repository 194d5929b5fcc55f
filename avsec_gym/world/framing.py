"""From labelled objects to a place around them: for layouts of our own and for real frames.

The world frame is then the vehicle frame of the rig that sees the objects.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, rectangle_corners, rectangle_polygons, wrap_angle
from avsec_gym.rig import SensorRig
from avsec_gym.world.actors import Actors
from avsec_gym.world.course import Course
from avsec_gym.world.ground import Ground
from avsec_gym.world.layouts.view import without_overlaps
from avsec_gym.world.section import CrossSection

EGO_DIMENSIONS = (1.50, 1.80, 4.70)
"""Height, width, length of the car with the sensors, metres."""
VEHICLES = ("Car", "Van", "Truck", "Tram", "Misc")

_LANE_WIDTH, _MEDIAN = 3.5, 3.0
_DROPPED_KERB = 0.025
_PLACES_ACROSS = 41
_UNEVEN = 0.035
"""Metres between an actor's corners and the land, from which on it is levelled."""
_PLANE_WEIGHT = 0.02
_SWELL_RADIUS = (2.5, 9.0)


class Parked(NamedTuple):
    """How far standing vehicles reach beside a road, metres to the left of its line."""

    right: float | None
    left: float | None


def actors_from_boxes(
    boxes: Boxes3D, rig: SensorRig, speed: Floats, rng: np.random.Generator
) -> Actors:
    """The ego vehicle at the origin and everything labelled, where it was labelled.

    Args:
        boxes: Boxes in the rig's camera frame; without `moving`, none moves.
        rig: The sensors that see them; their vehicle frame becomes the world frame.
        speed: Speed of each box along its heading, m/s, shape (N,).
        rng: Generator that draws looks and phases.
    """
    count = len(boxes)
    height, width, length = EGO_DIMENSIONS
    moving = np.zeros(count, bool) if boxes.moving is None else boxes.moving
    return Actors(
        id=np.arange(count + 1),
        category=np.concatenate([["Car"], boxes.category.astype(str)]),
        dimensions=np.concatenate([[(height, width, length)], boxes.dimensions]),
        pose=np.concatenate([np.zeros((1, 3)), boxes.poses]),
        z=np.concatenate([[0.0], rig.camera_height - boxes.location[:, 1]]),
        speed=np.concatenate([[0.0], np.where(moving, speed, 0.0)]),
        moving=np.concatenate([[False], moving]),
        appearance=rng.integers(2**31, size=count + 1),
        phase=rng.random(count + 1),
    )


def ground_through(actors: Actors, lift: Floats) -> Ground:
    """Land that passes below every actor.

    Args:
        actors: Actors at their heights; the ego vehicle is the first.
        lift: Height of the pavement (or nothing) between the land and each actor, shape (N,).
    """
    x, y = actors.pose[:, 0], actors.pose[:, 1]
    target = actors.z - lift
    # A plane that prefers to be level, then a swell below each actor that is still off it.
    columns = np.column_stack([np.ones_like(x), x, y])
    prior = np.diag([1e-3, _PLANE_WEIGHT * 2500.0, _PLANE_WEIGHT * 2500.0])
    weight = np.ones(len(x))
    weight[0] = 4.0
    plane = np.linalg.solve(
        columns.T @ (weight[:, None] * columns) + prior, columns.T @ (weight * target)
    )
    rest = target - columns @ plane
    apart = np.hypot(x[:, None] - x, y[:, None] - y) + np.where(np.eye(len(x)), np.inf, 0.0)
    radius = np.clip(0.6 * apart.min(axis=1, initial=30.0), *_SWELL_RADIUS)
    distance = np.where(np.isinf(apart), 0.0, apart)
    bumps = np.exp(-0.5 * (distance / radius[None, :]) ** 2)
    heights = np.linalg.solve(bumps + 1e-6 * np.eye(len(x)), rest)
    swells = np.column_stack([x, y, radius, heights])
    return Ground((float(plane[0]), float(plane[1]), float(plane[2])), swells)


def levelled(ground: Ground, actors: Actors, lift: Floats) -> Ground:
    """The land made level under every actor but the first whose wheels or feet it would not meet.

    Actors stand upright, since KITTI's boxes know no slopes: long ones on a slope would hang in
    the air at one end.

    Args:
        ground: The land.
        actors: Actors at their heights.
        lift: Height of the pavement (or nothing) between the land and each actor, shape (N,).
    """
    target = actors.z - lift
    corners = rectangle_corners(actors.pose, actors.dimensions[:, 2], actors.dimensions[:, 1])
    places = np.concatenate([corners, actors.pose[:, None, :2]], axis=1)
    pads = np.column_stack([actors.pose, actors.dimensions[:, [2, 1]], target])
    uneven = np.zeros(len(actors), bool)
    others = np.arange(len(actors)) > 0
    # A pad may tilt the ground under a neighbour.
    for _ in range(len(actors)):
        height = ground.height(places[..., 0], places[..., 1])
        more = others & (np.abs(height - target[:, None]).max(axis=1) > _UNEVEN)
        if not (more & ~uneven).any():
            break
        uneven |= more
        ground = replace(ground, pads=pads[uneven])
    return ground


def parked_beside(
    actors: Actors, course: Course, lanes: tuple[float, ...], lane_width: float
) -> Parked:
    """How far the standing vehicles beside the lanes reach, within 6 m of them."""
    poses = actors.pose[1:]
    standing = ~actors.moving[1:] & np.isin(actors.category[1:], VEHICLES)
    poses, dimensions = poses[standing], actors.dimensions[1:][standing]
    if len(poses) == 0:
        return Parked(None, None)
    corners = rectangle_corners(poses, dimensions[:, 2], dimensions[:, 1])
    _, left = course.coordinates(corners[..., 0], corners[..., 1])
    _, middle = course.coordinates(poses[:, 0], poses[:, 1])
    low, high = min(lanes) - 0.5 * lane_width, max(lanes) + 0.5 * lane_width
    right_hand = (middle < min(lanes) - 0.8) & (left.min(axis=1) > low - 6.0)
    left_hand = (middle > max(lanes) + 0.8) & (left.max(axis=1) < high + 6.0)
    return Parked(
        float(left[right_hand].min()) - 0.15 if right_hand.any() else None,
        float(left[left_hand].max()) + 0.15 if left_hand.any() else None,
    )


def lifted(actors: Actors, course: Course, section: CrossSection) -> Floats:
    """Height of what lies on the land below each actor (pavements), metres, shape (N,)."""
    _, left = course.coordinates(actors.pose[:, 0], actors.pose[:, 1])
    return section.height(left)


def with_dropped_kerbs(actors: Actors, course: Course, section: CrossSection) -> CrossSection:
    """The section, its kerbs lowered if an actor stands across one: none is to float or sink."""
    corners = rectangle_corners(actors.pose, actors.dimensions[:, 2], actors.dimensions[:, 1])
    _, left = course.coordinates(corners[..., 0], corners[..., 1])
    # All that lies under them: narrow islands hide between corners.
    below = np.linspace(left.min(axis=1), left.max(axis=1), _PLACES_ACROSS)
    if np.ptp(section.height(below), axis=0).max() <= _DROPPED_KERB:
        return section
    strips = tuple(
        replace(strip, height=min(strip.height, _DROPPED_KERB)) for strip in section.strips
    )
    return replace(section, strips=strips)


def with_street_behind(actors: Actors, course: Course, reach: float) -> Actors:
    """The street behind the ego vehicle peopled like the one ahead, which is all that labels know.

    Vehicles and people are mirrored to the rear along the road, keeping their side, heading and
    looks: no camera sees both, and each stands on the same strips of the road as its original.

    Args:
        actors: The ego vehicle, at road coordinate 0, and those ahead.
        course: The road's line.
        reach: Largest distance behind the ego vehicle at which an actor stands, metres.
    """
    along, left = course.coordinates(actors.pose[:, 0], actors.pose[:, 1])
    ahead = np.flatnonzero((along > 4.0) & (along < reach - 4.0))
    ahead = ahead[ahead > 0]
    behind = actors.pick(ahead)
    turn = behind.pose[:, 2] - course.poses(along[ahead], 0.0)[:, 2]
    pose = course.poses(-4.0 - along[ahead], left[ahead], -turn)
    both = np.concatenate([actors.pose, pose])
    size = np.concatenate([actors.dimensions, behind.dimensions])
    stays = without_overlaps(both, size[:, 2] + 0.3, size[:, 1] + 0.3)[len(actors) :]
    behind, pose = behind.pick(stays), pose[stays]
    count = len(behind)
    return Actors(
        id=np.arange(len(actors) + count),
        category=np.concatenate([actors.category, behind.category]),
        dimensions=np.concatenate([actors.dimensions, behind.dimensions]),
        pose=np.concatenate([actors.pose, pose]),
        z=np.concatenate([actors.z, behind.z]),
        speed=np.concatenate([actors.speed, behind.speed]),
        moving=np.concatenate([actors.moving, behind.moving]),
        appearance=np.concatenate([actors.appearance, behind.appearance]),
        phase=np.concatenate([actors.phase, behind.phase]),
    )


def keep_clear(
    actors: Actors, in_sight: NDArray[np.bool_], travel: float = 0.0
) -> list[shapely.Geometry]:
    """Areas without scenery: on every actor, in its way, and before those that are in sight.

    Args:
        actors: All actors; the first one looks, from its place.
        in_sight: Whether scenery must not hide each actor, shape (N,).
        travel: Time for which moving actors need a free way, seconds.
    """
    length, width = actors.dimensions[:, 2], actors.dimensions[:, 1]
    way = np.abs(actors.speed) * travel
    areas = list(rectangle_polygons(actors.pose, length + 2.0 * way + 0.8, width + 0.8))
    eye = shapely.Point(*actors.pose[0, :2])
    footprints = rectangle_polygons(actors.pose, length, width)
    for index in np.flatnonzero(in_sight):
        if index > 0:
            cone = shapely.union(eye, footprints[index])
            areas.append(shapely.convex_hull(cone))
    return areas


def highway_lanes(actors: Actors, course: Course, known: tuple[float, ...]) -> tuple[float, ...]:
    """Lanes under all vehicles in line with a highway, and an opposite carriageway.

    Args:
        actors: All actors.
        course: The highway's line.
        known: Middles of lanes that are there anyway, metres to the left of the line.
    """
    x, y, heading = actors.pose.T
    along, left = course.coordinates(x, y)
    turn = heading - course.poses(along, left)[:, 2]
    in_line = (np.abs(np.sin(turn)) < 0.25) & np.isin(actors.category, VEHICLES)
    in_line &= (left > -6.5) & (left < 20.0)
    lanes = list(known)
    for place in np.sort(left[in_line]):
        if min(abs(place - lane) for lane in lanes) > 2.4:
            lanes.append(float(place))
    lanes.sort()
    apart = np.diff(lanes)
    if len(apart) == 0 or apart.max() < _MEDIAN + _LANE_WIDTH:
        lanes += [lanes[-1] + _MEDIAN + _LANE_WIDTH, lanes[-1] + _MEDIAN + 2 * _LANE_WIDTH]
    return tuple(lanes)


def usual_heading(actors: Actors, near: float = 40.0) -> float:
    """Direction of the road as the vehicles near the ego vehicle suggest it, radians."""
    vehicles = np.isin(actors.category, VEHICLES) & (np.hypot(*actors.pose[:, :2].T) < near)
    vehicles[0] = False
    turned = wrap_angle(2.0 * actors.pose[vehicles, 2]) / 2.0
    along = turned[np.abs(turned) < 0.3]
    return float(np.median(along)) if len(along) >= 2 else 0.0
