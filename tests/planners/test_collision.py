"""The numba collision test against shapely."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from avsec_gym.geometry import rectangle_polygons
from avsec_gym.planners.collision import (
    CollisionWorld,
    collides,
    collision_world_of,
    obstacle_world,
)
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road, straight_lanes
from avsec_gym.scenario.shapes import Disc, Group, Polygon, Rectangle, Shape

HALF_LENGTH, HALF_WIDTH = 2.254, 0.805
TOUCHING = 1e-6
"""Metres: closer to touching than this, either answer is right."""

places = st.floats(-6, 6)
angles = st.floats(-7, 7)
lengths = st.floats(0.2, 6)
rectangles = st.builds(Rectangle, lengths, lengths, st.floats(-2, 2), st.floats(-2, 2), angles)
discs = st.builds(Disc, st.floats(0.1, 3), st.floats(-2, 2), st.floats(-2, 2))


@st.composite
def stars(draw: st.DrawFn) -> Polygon:
    """Polygons around a point, mostly concave, in either orientation."""
    radii = draw(st.lists(st.floats(0.5, 3), min_size=3, max_size=8))
    turn = np.arange(len(radii)) * 2 * np.pi / len(radii) * draw(st.sampled_from([1, -1]))
    x, y = draw(st.floats(-2, 2)), draw(st.floats(-2, 2))
    return Polygon(
        tuple(
            (x + r * float(np.cos(a)), y + r * float(np.sin(a)))
            for r, a in zip(radii, turn, strict=True)
        )
    )


simple = st.one_of(rectangles, discs, stars())
shapes = st.one_of(simple, st.builds(Group, st.lists(simple, min_size=1, max_size=3).map(tuple)))


def standing(shape: Shape, pose: tuple[float, float, float]) -> Obstacles:
    one = Obstacles.rectangles(np.array([pose]), np.ones(1), np.ones(1))
    return replace(one, shapes=(shape,))


def touches(world: CollisionWorld, x: float, y: float, heading: float, step: int = 0) -> bool:
    cos, sin = np.cos(heading), np.sin(heading)
    return bool(collides(x, y, cos, sin, HALF_LENGTH, HALF_WIDTH, step, world))


def ego(x: float, y: float, heading: float) -> shapely.Polygon:
    pose = np.array([x, y, heading])
    return rectangle_polygons(pose, np.array(2 * HALF_LENGTH), np.array(2 * HALF_WIDTH)).item()


def nearly_touching(one: shapely.Geometry, two: shapely.Geometry) -> bool:
    grown, shrunk = one.buffer(TOUCHING), one.buffer(-TOUCHING)
    return bool(grown.intersects(two)) and not bool(shrunk.intersects(two))


@settings(max_examples=300)
@given(shapes, places, places, angles, places, places, angles)
def test_every_shape_against_shapely(
    shape: Shape, ox: float, oy: float, turn: float, x: float, y: float, heading: float
) -> None:
    obstacles = standing(shape, (ox, oy, turn))
    area, car = obstacles.polygons(0)[0], ego(x, y, heading)
    assume(area.is_valid and not nearly_touching(car, area))
    # The judge's disc is a polygon around the disc: it may only be larger, by 0.01 %.
    if _has_disc(shape) and car.distance(area) == 0 and not car.intersects(area.buffer(-1e-3)):
        return
    world = obstacle_world(obstacles, np.zeros((0, 4)))
    assert touches(world, x, y, heading) == car.intersects(area)


def _has_disc(shape: Shape) -> bool:
    members = shape.shapes if isinstance(shape, Group) else (shape,)
    return any(isinstance(member, Disc) for member in members)


@pytest.mark.parametrize("turn", [0.0, 0.5, np.pi])
def test_shapes_turn_about_their_own_centres(turn: float) -> None:
    """As in commonroad-io, which shifts a centre off the origin and does not turn it."""
    shape = Rectangle(2.0, 1.0, x=3.0, y=1.0)
    area = standing(shape, (10.0, 5.0, turn)).polygons(0)[0]
    assert area.centroid.coords[0] == pytest.approx((13.0, 6.0))
    same = rectangle_polygons(np.array([13.0, 6.0, turn]), np.array(2.0), np.array(1.0)).item()
    assert area.symmetric_difference(same).area < 1e-9


def test_touching_counts() -> None:
    world = obstacle_world(standing(Rectangle(2.0, 1.0), (0.0, 1.25, 0.0)), np.zeros((0, 4)))
    assert collides(0.0, 0.0, 1.0, 0.0, 2.0, 0.75, 0, world)
    assert not collides(0.0, -1e-9, 1.0, 0.0, 2.0, 0.75, 0, world)


def moving(first: int, count: int) -> Obstacles:
    """A car along x at 10 m/s, 1 m a step."""
    poses = np.zeros((1, count, 3))
    poses[0, :, 0] = 20.0 + np.arange(count)
    return Obstacles(
        ids=np.array([1]),
        categories=np.array(["car"]),
        shapes=(Rectangle(4.0, 2.0),),
        poses=poses,
        speeds=np.full((1, count), 10.0),
        steps=np.array([count]),
        first_step=np.array([first]),
        static=np.array([False]),
    )


def test_moving_obstacle_at_each_step() -> None:
    obstacles = moving(first=3, count=10)
    world = obstacle_world(obstacles, np.zeros((0, 4)))
    for step in range(30):
        area = obstacles.polygons(step)[0]
        for x in np.arange(10.3, 40, 0.7):
            expected = area is not None and ego(x, 0.5, 0.2).intersects(area)
            assert touches(world, x, 0.5, 0.2, step) == expected


def test_last_state_is_kept_and_before_the_first_there_is_none() -> None:
    world = obstacle_world(moving(first=3, count=10), np.zeros((0, 4)))
    assert not touches(world, 20.0, 0.0, 0.0, step=2)
    assert touches(world, 20.0, 0.0, 0.0, step=3)
    assert touches(world, 29.0, 0.0, 0.0, step=12)
    assert touches(world, 29.0, 0.0, 0.0, step=1000)


def curved_road(radius: float, lanes: int, width: float = 3.0) -> Road:
    arc = np.linspace(-0.3, 1.2, 25)

    def bound(offset: float) -> tuple[tuple[float, float], ...]:
        r = radius - offset
        return tuple((float(r * np.sin(a)), float(radius - r * np.cos(a))) for a in arc)

    return Road(
        tuple(
            Lanelet(
                id=i + 1,
                left=bound((i + 0.5) * width),
                right=bound((i - 0.5) * width),
                adjacent_left=(i + 2, True) if i + 1 < lanes else None,
                adjacent_right=(i, True) if i else None,
            )
            for i in range(lanes)
        )
    )


ROADS = {
    "straight": Road(straight_lanes(3, 3.5, -10, 30)),
    "curved": curved_road(25.0, 2),
    "fork": Road(
        (
            *straight_lanes(1, 3.0, -10, 30),
            Lanelet(id=9, left=((0, 1.5), (25, 14)), right=((0, -1.5), (25, 10))),
        )
    ),
    "island": Road(
        (
            Lanelet(id=1, left=((-10, 9), (30, 9)), right=((-10, 5), (30, 5))),
            Lanelet(id=2, left=((-10, 0), (30, 0)), right=((-10, -4), (30, -4))),
            Lanelet(id=3, left=((-10, 6), (-4, 6)), right=((-10, -1), (-4, -1))),
            Lanelet(id=4, left=((24, 6), (30, 6)), right=((24, -1), (30, -1))),
        )
    ),
}


@pytest.mark.parametrize("name", ROADS)
@settings(max_examples=100)
@given(x=st.floats(-12, 32), y=st.floats(-6, 16), heading=angles)
def test_road_edge_against_shapely(name: str, x: float, y: float, heading: float) -> None:
    road, car = ROADS[name], ego(x, y, heading)
    assume(road.area.covers(car.buffer(-TOUCHING)) == road.area.covers(car.buffer(TOUCHING)))
    world = obstacle_world(Obstacles.none(), road.edges)
    assert touches(world, x, y, heading) == (not road.area.covers(car))


def test_without_lanelets_the_ground_is_free() -> None:
    world = collision_world_of(PlanningScenario("empty", start=None, goals=()))  # type: ignore[arg-type]
    assert not touches(world, 1e6, -1e6, 1.0)


def test_each_shape_is_cut_into_pieces_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """300 obstacles with 400 corners took 40 s to lay out, whatever the planner's time limit."""
    asked: list[Polygon] = []
    centre = Polygon.centre.fget  # type: ignore[attr-defined]
    monkeypatch.setattr(
        Polygon, "centre", property(lambda self: asked.append(self) or centre(self))
    )
    star = [(4 * np.cos(a) / (1 + i % 2), np.sin(a)) for i, a in enumerate(np.arange(0, 6, 0.3))]
    shapes = [Polygon(tuple((float(x) + k, float(y)) for x, y in star)) for k in (0.0, 1.0)]
    standing = Obstacles.rectangles(np.zeros((8, 3)), np.ones(8), np.ones(8))
    world = obstacle_world(replace(standing, shapes=tuple(shapes * 4)), np.zeros((0, 4)))
    assert len(world.poses) > 8 * 5
    assert len(asked) == 2
