from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import rectangle_corners, rectangle_polygons
from avsec_gym.rig import kitti_rig
from avsec_gym.world.actors import Actors
from avsec_gym.world.course import course_from_curvature
from avsec_gym.world.framing import (
    actors_from_boxes,
    ground_through,
    highway_lanes,
    keep_clear,
    levelled,
    parked_beside,
    usual_heading,
    with_dropped_kerbs,
    with_street_behind,
)
from avsec_gym.world.ground import Ground
from avsec_gym.world.section import CrossSection, Strip, Surface

STRAIGHT = course_from_curvature(np.zeros(301), start=-100.0)


def labelled(*rows) -> Boxes3D:
    """Boxes from (x ahead, y left, heading, moving), height of the bottom 1.65 m below."""
    x, y, heading, moving = np.array(rows, float).T
    count = len(rows)
    return Boxes3D(
        location=np.stack([-y, np.full(count, 1.65), x], axis=-1),
        dimensions=np.tile([1.5, 1.7, 4.2], (count, 1)),
        rotation_y=-heading - np.pi / 2,
        score=np.ones(count),
        category=np.full(count, "Car"),
        moving=moving.astype(bool),
    )


def crowd(*rows) -> Actors:
    boxes = labelled(*rows)
    return actors_from_boxes(boxes, kitti_rig(), np.full(len(rows), 8.0), np.random.default_rng(0))


def test_actors_are_the_ego_vehicle_and_everything_labelled() -> None:
    boxes = labelled((10, 3, 0.2, 1), (25, -4, -1.0, 0))
    lower = np.array([[0.0, 0.0, 0.0], [0.0, -0.45, 0.0]])
    boxes = replace(boxes, location=boxes.location + lower)
    actors = actors_from_boxes(boxes, kitti_rig(), np.array([7.0, 7.0]), np.random.default_rng(0))
    np.testing.assert_allclose(actors.pose, [[0, 0, 0], [10, 3, 0.2], [25, -4, -1.0]], atol=1e-12)
    np.testing.assert_allclose(actors.z, [0.0, 0.0, 0.45], atol=1e-12)
    assert actors.speed.tolist() == [0.0, 7.0, 0.0]
    assert actors.moving.tolist() == [False, True, False]
    assert actors.category.tolist() == ["Car"] * 3
    np.testing.assert_array_equal(actors.dimensions[1:], boxes.dimensions)
    assert len(set(actors.id)) == 3


places = st.tuples(st.floats(2, 80), st.floats(-20, 20), st.floats(-1.5, 1.5))


@settings(max_examples=60)
@given(st.lists(places, max_size=20))
def test_the_ground_passes_below_all_actors(rows: list[tuple[float, float, float]]) -> None:
    kept: list[tuple[float, float, float]] = []
    for row in rows:
        if all(np.hypot(row[0] - x, row[1] - y) > 0.5 for x, y, _ in kept):
            kept.append(row)
    actors = crowd(*((x, y, 0.0, 0) for x, y, _ in kept)) if kept else crowd((500, 0, 0, 0))
    z = np.array([0.0, *(z for *_, z in kept)]) if kept else np.zeros(2)
    # Neighbours cannot stand on heights that no ground could have.
    x, y = actors.pose[:, 0], actors.pose[:, 1]
    z = z * np.clip(np.hypot(x[:, None] - x, y[:, None] - y) + 9 * np.eye(len(x)), 0, 4).min(1) / 8
    actors = replace(actors, z=z)
    lift = np.where(np.arange(len(x)) % 2, 0.12, 0.0)
    ground = ground_through(actors, lift)
    assert np.abs(ground.height(x, y) + lift - z).max() < 0.01


def test_level_ground_stays_level_and_a_slope_a_slope() -> None:
    actors = crowd((10, 3, 0, 0), (30, -5, 0, 0), (60, 8, 0, 0), (45, 0, 0, 0))
    level = ground_through(actors, np.zeros(5))
    x, y = np.meshgrid(np.linspace(-20, 90, 30), np.linspace(-30, 30, 30))
    np.testing.assert_allclose(level.height(x, y), 0.0, atol=1e-9)
    uphill = replace(actors, z=0.03 * actors.pose[:, 0])
    slope = ground_through(uphill, np.zeros(5)).height(x[0], np.zeros(30))
    assert np.polyfit(x[0], slope, 1)[0] == pytest.approx(0.03, abs=0.005)


def test_swells_are_smooth_hills_where_they_are_said_to_be() -> None:
    ground = Ground((1.0, 0.1, -0.05), np.array([[10.0, 5.0, 4.0, 2.0]]))
    assert ground.height(10.0, 5.0) == pytest.approx(1 + 1.0 - 0.25 + 2.0)
    assert ground.height(14.0, 5.0) == pytest.approx(1 + 1.4 - 0.25 + 2 * np.exp(-0.5))
    assert ground.height(90.0, 5.0) == pytest.approx(1 + 9.0 - 0.25)
    assert ground.height(np.zeros((2, 3)), 0.0).shape == (2, 3)


def test_long_actors_on_a_slope_stand_on_level_ground() -> None:
    actors = crowd((20, 3, 0.3, 0), (40, -4, 0.0, 0), (45, -4, 0.1, 0))
    long = replace(actors, dimensions=actors.dimensions * np.array([[1], [3], [1], [1]]))
    slope = Ground((0.0, 0.02, 0.01))
    z = slope.height(long.pose[:, 0], long.pose[:, 1])
    ground = levelled(slope, replace(long, z=z), np.zeros(4))
    corners = rectangle_corners(long.pose, long.dimensions[:, 2], long.dimensions[:, 1])
    off = ground.height(corners[..., 0], corners[..., 1]) - z[:, None]
    assert np.abs(off[1:]).max() < 0.051
    assert np.abs(off[1]).max() < 0.005
    assert ground.height(20.0, 15.0) == pytest.approx(slope.height(20.0, 15.0))
    # As a grid in any order of memory.
    x, y = np.meshgrid(np.linspace(0, 60, 13), np.linspace(-20, 20, 9), indexing="ij")
    np.testing.assert_array_equal(ground.height(x, y), ground.height(x.T, y.T).T)


@pytest.mark.parametrize("across", [0.0, 0.2, 1.2])
def test_kerbs_are_lowered_where_an_actor_stands_on_an_island(across: float) -> None:
    strips = (
        Strip(Surface.ROAD, -2.0, 2.0),
        Strip(Surface.PAVEMENT, 2.0, 3.0, 0.12, "slabs"),
        Strip(Surface.ROAD, 3.0, 6.0),
    )
    section = CrossSection(strips, (), ())
    on_island = with_dropped_kerbs(crowd((20, 2.5, across, 0)), STRAIGHT, section)
    assert max(strip.height for strip in on_island.strips) < 0.05
    assert with_dropped_kerbs(crowd((20, -0.5, 0.0, 0)), STRAIGHT, section) is section


def test_the_street_behind_follows_the_bends_of_the_road() -> None:
    course = course_from_curvature(np.full(301, 0.01), start=-150.0)
    ahead = course.poses([20.0, 35.0, 90.0], [4.0, -5.0, 4.0])
    both = with_street_behind(crowd(*((*pose, 0) for pose in ahead)), course, 60.0)
    along, left = course.coordinates(both.pose[4:, 0], both.pose[4:, 1])
    np.testing.assert_allclose(along, [-24.0, -39.0], atol=0.05)
    np.testing.assert_allclose(left, [4.0, -5.0], atol=0.02)


def test_the_street_behind_mirrors_the_one_ahead_without_collisions() -> None:
    actors = crowd((8, 3, 0.0, 0), (14, 3.2, np.pi, 1), (30, -4, 0.1, 0), (2, 3, 0.0, 0))
    both = with_street_behind(actors, STRAIGHT, 60.0)
    for name in ("pose", "dimensions", "category", "appearance"):
        np.testing.assert_array_equal(getattr(both, name)[:5], getattr(actors, name))
    assert (both.pose[5:, 0] < -4).all()
    assert len(both) > 5
    assert len(set(both.id)) == len(both)
    np.testing.assert_allclose(np.sort(both.pose[5:, 1])[0], -4.0)
    shapes = rectangle_polygons(both.pose, both.dimensions[:, 2], both.dimensions[:, 1])
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    assert (first == second).all()


def test_scenery_keeps_off_actors_their_way_and_lines_of_sight() -> None:
    actors = crowd((20, 6, 0.0, 1), (30, -8, 0.0, 0))
    area = shapely.union_all(keep_clear(actors, np.array([False, True, False]), 0.5))
    shapes = rectangle_polygons(actors.pose, actors.dimensions[:, 2], actors.dimensions[:, 1])
    assert all(area.contains(shape) for shape in shapes)
    for share in np.linspace(0.02, 1, 9):
        assert area.contains(shapely.Point(20 * share, 6 * share))
    assert not area.contains(shapely.Point(18.0, -4.8))  # not to be kept in sight
    assert area.contains(shapely.Point(20 + 2.1 + 0.5 * 8.0, 6))  # where it drives


def test_parked_rows_are_where_vehicles_stand_beside_the_lanes() -> None:
    actors = crowd(
        (10, -3.0, 0, 0), (20, -3.2, 0, 0), (15, 7.0, np.pi, 0), (30, 0, 0, 0), (40, -9, 0, 1)
    )
    parked = parked_beside(actors, STRAIGHT, (0.0, 3.3), 3.5)
    assert parked.right == pytest.approx(-3.2 - 0.85, abs=0.3)
    assert parked.left == pytest.approx(7.0 + 0.85, abs=0.3)
    none = parked_beside(crowd((30, 0, 0, 1)), STRAIGHT, (0.0,), 3.5)
    assert (none.right, none.left) == (None, None)


def test_a_highway_has_a_lane_under_every_vehicle_in_line() -> None:
    actors = crowd((20, 3.6, 0.0, 1), (40, 7.0, 0.0, 1), (35, -3.4, 0.02, 1), (60, 14.5, np.pi, 1))
    lanes = np.array(highway_lanes(actors, STRAIGHT, (0.0,)))
    assert (np.diff(lanes) > 2.0).all()
    for place in actors.pose[:, 1]:
        assert np.abs(lanes - place).min() < 2.41
    assert np.diff(lanes).max() > 5.0  # somewhere there is a median


@pytest.mark.parametrize("heading", [-0.2, 0.0, 0.15])
def test_the_road_runs_as_most_vehicles_stand(heading: float) -> None:
    rows = [(10 + 5 * i, 3, heading + np.pi * (i % 2), 0) for i in range(5)]
    across = (15, -6, heading + np.pi / 2, 0)
    assert usual_heading(crowd(*rows, across)) == pytest.approx(heading, abs=1e-9)
    assert usual_heading(crowd(across)) == 0.0
