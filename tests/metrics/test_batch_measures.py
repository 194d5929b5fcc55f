"""Measures of a few made-up trajectories, by shapely and scipy, one at a time."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
import shapely.affinity
from scipy.integrate import simpson

from avsec_gym.metrics.batch_measures import _lane_heading, _rectangle_distance, batch_measures
from avsec_gym.metrics.collision_check import TrajectoryBatch
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road

LANES = Road(
    (
        Lanelet(1, left=((0, 2), (10, 2), (20, 9)), right=((0, -2), (12, -2), (24, 5))),
        Lanelet(2, left=((25, -9), (12, -9), (-1, -5)), right=((25, -5), (12, -5), (-1, -1))),
    )
)
"""One lane that bends to the left, and one that comes back below it."""


def _scenario(road: Road, wanted: tuple[float, ...], dt: float) -> PlanningScenario:
    goals = tuple(Goal((5, 9), velocity=(each, 30.0)) for each in wanted) or (Goal((5, 9)),)
    return PlanningScenario("made up", EgoState(), goals, road, Obstacles.none(), dt)


def _rectangle(length: float, width: float, x: float, y: float, heading: float) -> shapely.Polygon:
    box = shapely.box(-length / 2, -width / 2, length / 2, width / 2)
    turned = shapely.affinity.rotate(box, heading, origin=(0, 0), use_radians=True)
    return shapely.affinity.translate(turned, x, y)


def _integral(values: np.ndarray, dt: float) -> float:
    return float(simpson(values, dx=dt)) if len(values) > 1 else 0.0


def _lane_direction(place: np.ndarray, road: Road) -> float:
    starts, ends = road.centre_segments
    if not len(starts):
        return 0.0
    lines = shapely.linestrings(np.stack([starts, ends], axis=1))
    along = (ends - starts)[int(np.argmin(shapely.distance(lines, shapely.Point(place))))]
    return float(np.arctan2(along[1], along[0]))


def _sm1(states: np.ndarray, road: Road, wanted: tuple[float, ...], dt: float) -> float:
    turned = states[:, 3] - [_lane_direction(place, road) for place in states[:, :2]]
    turned = np.angle(np.exp(1j * turned))
    at_states = 50 * states[:, 4] ** 2 + states[:, 2] + 50 * turned**2
    if wanted:
        at_states += 20 * (min(wanted) - states[:, 2]) ** 2
    change = np.diff(states, axis=0) / dt
    between = 50 * change[:, 2] ** 2 + 50 * change[:, 4] ** 2
    return _integral(at_states, dt) + _integral(between, dt)


@pytest.mark.parametrize("road", [LANES, Road(())], ids=["lanes", "none"])
@pytest.mark.parametrize("wanted", [(), (7.0,), (9.0, 5.0)])
@pytest.mark.parametrize("moving", [True, False])
@pytest.mark.parametrize("dt", [0.1, 0.5])
def test_each_trajectory_measures_what_it_does_alone(
    road: Road, wanted: tuple[float, ...], moving: bool, dt: float
) -> None:
    rng = np.random.default_rng(len(wanted) + 2 * moving)
    batch, steps, others = 9, 8, 3
    states = np.stack(
        [
            rng.uniform(0, 25, (batch, 1)) + np.cumsum(rng.normal(0.5, 0.5, (batch, steps)), 1),
            rng.uniform(-7, 7, (batch, 1)) + np.cumsum(rng.normal(0.0, 0.5, (batch, steps)), 1),
            rng.uniform(0, 12, (batch, steps)),
            rng.uniform(-4, 4, (batch, steps)),
            rng.uniform(-0.4, 0.4, (batch, steps)),
        ],
        axis=-1,
    )
    lengths = np.array([8, 7, 6, 5, 4, 3, 2, 1, 11])
    at = rng.uniform((-5, -20, -4), (35, 20, 4), (batch, others, steps if moving else 1, 3))
    at[3:5, 0, :, :2], at[4] = 1e7, 1e7
    poses = np.concatenate([at[..., :2], np.cos(at[..., 2:]), np.sin(at[..., 2:])], axis=-1)
    half = rng.uniform((0.2, 0.2), (3.0, 1.0), (batch, others, 2))
    measured = batch_measures(
        TrajectoryBatch(states, lengths, poses, half), BMW_320I, _scenario(road, wanted, dt)
    )
    for b in range(batch):
        own = states[b, : lengths[b]]
        path = np.hypot(*np.diff(own[:, :2], axis=0).T).sum()
        assert measured.path_length[b] == pytest.approx(path)
        assert measured.cost_sm1[b] == pytest.approx(_sm1(own, road, wanted, dt))
        away = [
            _rectangle(BMW_320I.length, BMW_320I.width, x, y, heading).distance(
                _rectangle(*(2 * half[b, i]), *at[b, i, t if moving else 0])
            )
            for t, (x, y, _, heading, _) in enumerate(own)
            for i in range(others)
        ]
        if b == 4:
            assert measured.smallest_distance[b] == np.inf
        else:
            assert measured.smallest_distance[b] == pytest.approx(min(away), abs=1e-9)
    assert len(np.unique(measured.smallest_distance)) > 4


def test_nothing_is_as_far_as_can_be() -> None:
    batch = TrajectoryBatch(
        np.zeros((2, 3, 5)), np.array([3, 0]), np.zeros((2, 0, 1, 4)), np.zeros((2, 0, 2))
    )
    measured = batch_measures(batch, BMW_320I, _scenario(LANES, (), 0.1))
    assert measured.smallest_distance.tolist() == [np.inf, np.inf]
    assert measured.path_length.tolist() == [0.0, 0.0]
    assert measured.cost_sm1[1] == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_two_rectangles_are_as_far_apart_as_shapely_finds(seed: int) -> None:
    rng, touching = np.random.default_rng(seed), 0
    for _ in range(250):
        one, two = rng.uniform(0.2, 3.0, (2, 2))
        x, y = rng.uniform(-6, 6, 2)
        turn = float(rng.choice([0.0, np.pi / 2, rng.uniform(-4, 4)]))
        expected = _rectangle(*(2 * one), 0, 0, 0).distance(_rectangle(*(2 * two), x, y, turn))
        found = _rectangle_distance(tuple(one), tuple(two), x, y, np.cos(turn), np.sin(turn))
        assert found == pytest.approx(expected, abs=1e-9)
        touching += expected == 0.0
    assert 25 < touching < 225


def test_a_place_has_the_direction_of_the_nearest_segment() -> None:
    rng = np.random.default_rng(0)
    starts, ends = LANES.centre_segments
    along = ends - starts
    squares = (along**2).sum(axis=1)
    for x, y in rng.uniform((-8, -12), (32, 15), (200, 2)):
        found = _lane_heading(x, y, starts, along, squares)
        assert found == pytest.approx(_lane_direction(np.array([x, y]), LANES))
    assert _lane_heading(1.0, 2.0, starts[:0], along[:0], squares[:0]) == 0.0
