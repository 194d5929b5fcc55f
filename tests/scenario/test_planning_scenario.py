"""Roads, obstacles over time, and shapes."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road, straight_lanes
from avsec_gym.scenario.shapes import Disc, Group, Polygon, Rectangle, placed


def test_straight_lanes_lie_side_by_side() -> None:
    lanes = straight_lanes(3, 3.5, -10.0, 50.0)
    road = Road(lanes)
    assert road.area.equals(shapely.box(-10, -5.25, 50, 5.25))
    assert len(road.edges) == 4
    assert [lane.adjacent_left for lane in lanes] == [(2, True), (3, True), None]
    assert [lane.adjacent_right for lane in lanes] == [None, (1, True), (2, True)]
    assert lanes[1].polygon().centroid.y == pytest.approx(0.0)


def lane(number: int, left: object, right: object, **more: object) -> Lanelet:
    return Lanelet(number, tuple(left), tuple(right), **more)  # type: ignore[arg-type]


def test_only_outer_bounds_of_neighbours_count() -> None:
    """Neighbours that sample their common bound differently leave no slit."""
    low = lane(1, [(0, 3), (4, 2.9), (9, 3)], [(0, 0), (9, 0)], adjacent_left=(2, True))
    high = lane(2, [(0, 6), (9, 6)], [(0, 3), (5, 3.1), (9, 3)], adjacent_right=(1, True))
    assert Road((low, high)).area.equals(shapely.box(0, 0, 9, 6))
    apart = Road((lane(1, low.left, low.right), lane(2, high.left, high.right)))
    assert apart.area.area < 9 * 6 - 0.5


def test_a_neighbour_in_the_other_direction() -> None:
    here = lane(1, [(0, 3), (9, 3)], [(0, 0), (9, 0)], adjacent_left=(2, False))
    oncoming = lane(2, [(9, 3), (0, 3)], [(9, 6), (0, 6)], adjacent_left=(1, False))
    for lanes in ((here, oncoming), (oncoming, here)):
        assert Road(lanes).area.equals(shapely.box(0, 0, 9, 6))


def test_gaps_between_sections_stay_gaps_but_for_rounding() -> None:
    one = lane(1, [(0, 3), (9, 3)], [(0, 0), (9, 0)])
    for gap, parts in ((0.0, 1), (1e-13, 1), (1e-3, 2)):
        two = lane(2, [(9 + gap, 3), (20, 3)], [(9 + gap, 0), (20, 0)])
        assert len(shapely.get_parts(Road((one, two)).area)) == parts


def test_strange_neighbourhoods_do_not_hang() -> None:
    missing = lane(1, [(0, 3), (9, 3)], [(0, 0), (9, 0)], adjacent_left=(7, True))
    assert Road((missing,)).area.area == pytest.approx(27)
    itself = lane(1, [(0, 3), (9, 3)], [(0, 0), (9, 0)], adjacent_left=(1, True))
    assert Road((itself,)).area.area > 0
    assert Road().edges.shape == (0, 4)


@given(st.integers(0, 40), st.floats(0.5, 20), st.floats(-3, 3))
def test_constant_velocity(step: int, speed: float, heading: float) -> None:
    obstacles = Obstacles.rectangles(
        np.array([[1.0, 2.0, heading], [5.0, 5.0, 0.0]]),
        np.array([4.0, 4.0]),
        np.array([2.0, 2.0]),
        np.array([speed, 0.0]),
        last_step=20,
    )
    driving, standing = obstacles.polygons(step)
    way = speed * 0.1 * min(step, 20)
    assert driving.centroid.x == pytest.approx(1 + way * np.cos(heading), abs=1e-6)
    assert driving.centroid.y == pytest.approx(2 + way * np.sin(heading), abs=1e-6)
    assert standing.centroid.x == pytest.approx(5)
    assert obstacles.static.tolist() == [False, True]
    assert obstacles.categories.tolist() == ["car", "parkedVehicle"]


def test_before_its_first_state_an_obstacle_is_absent() -> None:
    from dataclasses import replace

    obstacles = Obstacles.rectangles(
        np.zeros((2, 3)), np.ones(2), np.ones(2), np.array([5.0, 0.0]), last_step=3
    )
    late = replace(obstacles, first_step=np.array([4, 4]))
    assert late.polygons(3)[0] is None
    assert late.polygons(3)[1] is not None
    assert late.pose_index(3).tolist() == [-1, 0]
    assert late.pose_index(100).tolist() == [3, 0]


def test_concave_polygon_is_tiled_by_convex_pieces() -> None:
    corner = Polygon(((0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3)))
    pieces = [shapely.Polygon(piece.vertices) for piece in corner.convex_pieces()]
    assert len(pieces) > 1
    assert sum(piece.area for piece in pieces) == pytest.approx(corner.polygon().area)
    assert shapely.union_all(pieces).symmetric_difference(corner.polygon()).area < 1e-12
    assert all(piece.equals(piece.convex_hull) for piece in pieces)
    square = Polygon(((0, 0), (0, 1), (1, 1), (1, 0)))
    assert len(square.convex_pieces()) == 1


def test_disc_of_the_judge_covers_the_disc() -> None:
    area = Disc(2.0, 1.0, -1.0).polygon()
    assert area.exterior.distance(shapely.Point(1.0, -1.0)) >= 2.0 - 1e-12
    assert area.area == pytest.approx(np.pi * 4, rel=1e-3)


def test_members_of_a_group_turn_about_their_own_centres() -> None:
    group = Group((Rectangle(4.0, 1.0, 3.0, 0.0), Disc(0.5, 0.0, 2.0)))
    area = placed(group, np.array([10.0, 0.0, np.pi / 2]))
    assert area.covers(shapely.Point(13.0, 1.9))
    assert area.covers(shapely.Point(10.0, 2.4))
    assert not area.covers(shapely.Point(14.9, 0.0))
    assert len(group.convex_pieces()) == 2


def test_last_step_is_the_latest_of_all_goals() -> None:
    scenario = PlanningScenario("x", EgoState(), (Goal((0, 9)), Goal((4, 7))))
    assert scenario.last_step == 9
    obstacles = Obstacles.rectangles(np.zeros((1, 3)), np.ones(1), np.ones(1))
    assert len(scenario.with_obstacles(obstacles).obstacles) == 1
    assert len(scenario.obstacles) == 0


@pytest.mark.parametrize("denser", ["left", "right"])
def test_the_centre_between_bounds_with_different_numbers_of_points(denser: str) -> None:
    """Costs of trajectories look at it; bounds of neighbours may be sampled differently."""
    dense, sparse = ((0.0, 1.0), (4.0, 1.0), (9.0, 1.0)), ((0.0, -1.0), (9.0, -1.0))
    lanelet = Lanelet(1, dense, sparse) if denser == "left" else Lanelet(1, sparse, dense)
    starts, ends = Road((lanelet,)).centre_segments
    np.testing.assert_allclose(starts, [(0, 0), (4, 0)])
    np.testing.assert_allclose(ends, [(4, 0), (9, 0)])
