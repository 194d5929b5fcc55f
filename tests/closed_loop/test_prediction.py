"""Where believed objects will be, on roads whose bends are known."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.closed_loop.procedural_drives import road_of
from avsec_gym.closed_loop.traffic_scene import thesis_road
from avsec_gym.geometry import Floats
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.road import Lanelet, Road
from avsec_gym.world.course import course_from_curvature
from avsec_gym.world.section import CrossSection, Lane, Strip, Surface

RADIUS, WIDTH, SPEED, DT = 100.0, 3.5, 10.0, 0.1
TIMES = DT * np.arange(31)
SECTION = CrossSection(
    (Strip(Surface.ROAD, -1.75, 5.25),), (), (Lane(0.0, 1, 10.0), Lane(WIDTH, -1, 10.0))
)
BENT = Lanes(road_of(course_from_curvature(np.full(201, 1 / RADIUS)), SECTION))
"""A bend to the left: lane 1 runs along the course, lane 2 on its inside against it."""


def predicted(pose: tuple[float, float, float], speed: float, lanes: Lanes | None) -> Floats:
    """Poses of one believed car from now on, shape (31, 3)."""
    car = (np.array([value]) for value in (4.0, 1.8, speed))
    return Belief(0.0, np.array([pose]), *car, RoadType.STREET).obstacles(lanes).poses[0]


def centre() -> Floats:
    """The centre of the bend: the same distance to the left everywhere."""
    x, y, heading = BENT.line(1).pose(150.0)
    return np.array([x - RADIUS * np.sin(heading), y + RADIUS * np.cos(heading)])


def straight(pose: tuple[float, float, float], speed: float) -> Floats:
    x, y, heading = pose
    way = speed * TIMES
    ahead = np.column_stack([np.cos(heading) * way, np.sin(heading) * way, 0.0 * way])
    return np.array([x, y, heading]) + ahead


@pytest.mark.parametrize(("lane", "radius"), [(1, RADIUS), (2, RADIUS - WIDTH)])
@pytest.mark.parametrize("left", [0.0, 0.4])
def test_in_a_bend_a_car_stays_in_its_lane(lane: int, radius: float, left: float) -> None:
    """On a circle about the bend's centre; straight on it would leave the lane in three seconds."""
    x, y = BENT.line(lane).place(150.0, left)
    pose = x, y, BENT.line(lane).heading(150.0)
    found = predicted(pose, SPEED, BENT)
    np.testing.assert_allclose(found[0], pose, atol=1e-9)
    outwards = radius - left if lane == 1 else radius + left
    away = np.hypot(*(found[:, :2] - centre()).T)
    np.testing.assert_allclose(away, outwards, atol=0.06)
    driven = np.hypot(*np.diff(found[:, :2], axis=0).T)
    np.testing.assert_allclose(driven, SPEED * DT, rtol=0.02)
    turned = (1 if lane == 1 else -1) * SPEED * TIMES / outwards
    np.testing.assert_allclose(found[:, 2] - pose[2], turned, atol=0.03)
    kept = predicted(pose, SPEED, None)
    assert np.hypot(*(kept[-1, :2] - centre())) > outwards + 0.5 * WIDTH


def test_who_changes_lanes_in_a_bend_goes_on_to_change_them() -> None:
    x, y, heading = BENT.line(1).pose(150.0)
    found = predicted((x, y, heading + 0.1), SPEED, BENT)
    lefts = RADIUS - np.hypot(*(found[:, :2] - centre()).T)
    np.testing.assert_allclose(lefts, SPEED * np.sin(0.1) * TIMES, atol=0.1)


@pytest.mark.parametrize(("left", "turned"), [(0.0, 1.2), (-4.0, 0.0), (0.0, -0.6)])
def test_who_crosses_or_is_beside_the_road_goes_straight_on(left: float, turned: float) -> None:
    x, y = BENT.line(1).place(150.0, left)
    pose = x, y, BENT.line(1).heading(150.0) + turned
    np.testing.assert_allclose(predicted(pose, 2.0, BENT), straight(pose, 2.0), atol=1e-9)


def test_what_stands_stays_where_it_is() -> None:
    pose = BENT.line(1).pose(150.0)
    np.testing.assert_array_equal(predicted(pose, 0.0, BENT), np.array([pose]))


def test_on_straight_lanes_nothing_changes() -> None:
    """Bit for bit: the first plan there is the single query's."""
    lanes = Lanes(thesis_road())
    for pose in ((20.0, 0.3, 0.05), (40.0, 3.4, -np.pi + 0.1)):
        np.testing.assert_array_equal(predicted(pose, 8.0, lanes), predicted(pose, 8.0, None))


@pytest.mark.parametrize(("successors", "end"), [((2,), (30.0, 20.0)), ((2, 3), (50.0, 0.0))])
def test_beyond_a_fork_a_car_goes_straight_on(
    successors: tuple[int, ...], end: tuple[float, float]
) -> None:
    """It follows an only successor around a corner, and the first of two no further."""

    def lanelet(id: int, x: float, heading: float, after: tuple[int, ...] = ()) -> Lanelet:
        """30 m of lane with a point on each."""
        ahead = np.array([np.cos(heading), np.sin(heading)])
        points = np.array([x, 0.0]) + np.arange(31.0)[:, None] * ahead
        aside = 2.0 * np.array([-ahead[1], ahead[0]])
        left, right = (tuple(map(tuple, (points + s * aside).tolist())) for s in (1, -1))
        return Lanelet(id, left, right, (), after)

    first = lanelet(1, 0.0, 0.0, successors)
    lanes = Lanes(Road((first, lanelet(2, 30.0, np.pi / 2), lanelet(3, 30.0, 0.0))))
    found = predicted((20.0, 0.0, 0.0), 10.0, lanes)
    np.testing.assert_allclose(found[-1, :2], end, atol=1e-9)
