"""Where ghosts are, and what chance would give."""

import numpy as np
import pytest

from avsec_gym.attacks.side_area import RoadView
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.ghost_positions import (
    GhostCount,
    GhostPlace,
    count_ghosts,
    ghost_summary,
    in_corridor,
    placed_ghosts,
    places,
    visible_areas,
)
from avsec_gym.rig import kitti_rig

CALIBRATION = kitti_rig().calibration
P = CALIBRATION.projection()


def cars(*x_and_z, score=1.0, category="Car", box2d=None):
    count = len(x_and_z)
    location = np.array([[x, 1.65, z] for x, z in x_and_z]).reshape(-1, 3)
    sizes = np.tile([1.5, 1.6, 4.0], (count, 1))
    heading = np.full(count, -np.pi / 2)  # They look ahead.
    scores = np.broadcast_to(score, count)
    return Boxes3D(location, sizes, heading, scores, np.full(count, category), box2d)


def view(half_width=4.0, wall=None):
    """A straight road and verges on a plane 1.65 m below the camera; a wall as a 2D box."""
    v, u = np.indices((375, 1242), dtype=float)
    below = v > P[1, 2] + 5
    depth = np.where(below, P[1, 1] * 1.65 / np.where(below, v - P[1, 2], 1), np.inf)
    x = np.where(below, (u - P[0, 2]) * np.where(below, depth, 0) / P[0, 0], np.inf)
    parallax = CALIBRATION.focal_length() * CALIBRATION.baseline()
    disparity = np.where(below, parallax / depth, 0)
    road, side = below & (np.abs(x) < half_width), below & (np.abs(x) >= half_width)
    if wall is not None:
        rows, columns, far = wall
        road[rows, columns], side[rows, columns] = False, True
        disparity[rows, columns] = parallax / far
    return RoadView(road, side, disparity.astype(np.float32))


def test_the_corridor_takes_in_whatever_reaches_into_it():
    assert in_corridor(cars((0, 20), (5.9, 20), (6.2, 20), (-5.9, 20))).tolist() == [
        True,
        True,
        False,
        True,
    ]


def test_places_are_told_by_what_the_image_shows_at_the_foot():
    boxes = cars((0, 20), (6, 20), (30, 10), (0, 5.0))
    found = places(boxes, view(), CALIBRATION)
    assert found == [GhostPlace.ROAD, GhostPlace.SIDE, GhostPlace.UNKNOWN, GhostPlace.UNKNOWN]


def test_areas_are_those_of_the_ground_that_is_seen():
    """Trapezoids between 6.3 m, where a row at the image's bottom looks, and 20 m."""
    nearest = P[1, 1] * 1.65 / (374 - P[1, 2])
    road, side = visible_areas(view(), CALIBRATION, farthest=20)
    half_angles = [P[0, 2] / P[0, 0], (1241 - P[0, 2]) / P[0, 0]]
    depth = np.linspace(nearest, 20, 10_000)
    seen = [np.minimum(depth * angle, 4) for angle in half_angles]
    expected_road = np.trapezoid(seen[0] + seen[1], depth)
    expected_side = np.trapezoid(depth * sum(half_angles), depth) - expected_road
    assert road == pytest.approx(expected_road, rel=0.06)
    assert side == pytest.approx(expected_side, rel=0.06)


def test_walls_have_no_area():
    wall = slice(100, 240), slice(800, 1242), 15.0
    without, with_wall = (
        visible_areas(view(wall=each), CALIBRATION, farthest=40) for each in (None, wall)
    )
    assert with_wall[1] < without[1]
    assert with_wall[0] <= without[0]


def test_counts_of_a_frame():
    """Real; ahead; on the road yet out of the lanes; beside; too far; too unsure."""
    spots = ((0, 12), (0, 20), (7, 20), (10, 20), (10, 60), (-8, 18))
    found = cars(*spots, score=[0.9, 0.9, 0.9, 0.9, 0.9, 0.1])
    seen = view(half_width=8.0)
    unreal, where = placed_ghosts(found, cars((0, 12)), seen, CALIBRATION, threshold=0.5)
    assert unreal.location[:, 0].tolist() == [0, 7, 10]
    assert count_ghosts(unreal, where, (3.0, 4.0)) == GhostCount(2, 1, 0, 1, 3.0, 4.0)


def test_ghosts_spread_evenly_give_what_chance_gives():
    rng = np.random.default_rng(0)
    areas = rng.uniform(50, 400, (400, 2))
    frames = []
    for road, side in areas:
        on_road = rng.binomial(5, road / (road + side))
        frames.append(GhostCount(int(on_road), int(5 - on_road), 0, 0, road, side))
    summary = ghost_summary(frames, resamples=1000)
    low, high = summary.ratio.interval
    assert low < 1 < high
    assert high - low < 0.4
    assert summary.share_on_road.value == pytest.approx(summary.chance.value, abs=0.03)


def test_a_true_preference_is_seen_and_frames_are_the_cases():
    """One ghost in ten on the road though it is half of the ground; one frame alone says little."""
    many = [GhostCount(i % 10 == 0, i % 10 != 0, 0, 0, 100, 100) for i in range(200)]
    assert ghost_summary(many, resamples=500).ratio.interval[1] < 0.3
    odd, usual = GhostCount(1, 99, 0, 0, 100, 100), GhostCount(2, 0, 0, 1, 100, 100)
    one = ghost_summary([odd] + [usual] * 5)
    low, high = one.share_on_road.interval
    assert low < 0.05
    assert high > 0.5
    alone = ghost_summary([odd, GhostCount(0, 0, 2, 0, 100, 100)])
    assert (alone.share_on_road.value, alone.share_on_road.interval) == (0.01, None)
    assert one.share_in_lanes.value == pytest.approx(5 / 110)


def test_without_ghosts_nothing_is_claimed():
    for frames in ([], [GhostCount(0, 0, 3, 0, 100, 100)]):
        summary = ghost_summary(frames, resamples=100)
        assert summary.share_on_road.value is None
        assert summary.ratio.interval is None
