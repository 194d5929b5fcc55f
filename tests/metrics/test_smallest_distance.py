"""Smallest distances by hand, and measures of batches against those of single trajectories."""

from __future__ import annotations

import math

import numpy as np
import pytest

from avsec_gym.geometry import rectangle_polygons
from avsec_gym.metrics.batch_measures import batch_measures
from avsec_gym.metrics.collision_check import TrajectoryBatch, first_contact, present_poses
from avsec_gym.metrics.smallest_distance import smallest_distance
from avsec_gym.metrics.trajectory_cost import path_length, sm1_cost
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.scene_sets import procedural_scenes

FAR = 1e7


def parked(x: float, y: float, heading: float = 0.0) -> Obstacles:
    return Obstacles.rectangles(np.array([[x, y, heading]]), np.array([4.0]), np.array([2.0]))


def along_x(steps: int = 11, speed: float = 10.0) -> np.ndarray:
    states = np.zeros((steps, 5))
    states[:, 0], states[:, 2] = 0.1 * speed * np.arange(steps), speed
    return states


def test_a_car_beside_the_lane_is_passed_at_its_side() -> None:
    between = 3.0 - 1.0 - BMW_320I.width / 2
    assert smallest_distance(along_x(), parked(5.0, 3.0), BMW_320I) == pytest.approx(between)
    turned = 3.0 - 2.0 - BMW_320I.width / 2
    seen = smallest_distance(along_x(), parked(5.0, 3.0, np.pi / 2), BMW_320I)
    assert seen == pytest.approx(turned)


def test_nothing_is_nearer_than_what_is_touched_or_farther_than_nothing() -> None:
    assert smallest_distance(along_x(), parked(8.0, 0.0), BMW_320I) == 0.0
    nothing = Obstacles.rectangles(np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    assert smallest_distance(along_x(), nothing, BMW_320I) == math.inf


@pytest.mark.parametrize("moving", [False, True])
def test_a_batch_measures_what_single_trajectories_do(moving: bool) -> None:
    """Every planned drive of some layouts, the planner blind, so that some touch something."""
    planner = MotionPrimitivePlanner()
    scenes = [s for s in procedural_scenes(40).labelled if bool(s.speeds.any()) == moving]
    touched = 0
    for scene in scenes:
        blind = scene.problem(Intention.STRAIGHT).with_obstacles(parked(90.0, 0.0))
        plan, truth = planner.plan(blind), scene.truth()
        if plan.trajectory is None or not len(truth):
            continue
        states = len(plan.trajectory)
        # As the environments lay them out: padded in time and with obstacles that are not there.
        trajectory = np.concatenate([plan.trajectory, np.full((3, 5), 77.0)])
        _, at = present_poses(states + 3, truth)
        x, y, heading = np.moveaxis(at, 2, 0)
        poses = np.full((1, len(truth) + 2, states + 3, 4), FAR)
        poses[0, :-2] = np.stack([x, y, np.cos(heading), np.sin(heading)], -1).swapaxes(0, 1)
        sizes = np.zeros((1, len(truth) + 2, 2))
        sizes[0, :-2] = [(0.5 * s.length, 0.5 * s.width) for s in truth.shapes]  # type: ignore[union-attr]
        measured = batch_measures(
            TrajectoryBatch(trajectory[None], np.array([states]), poses, sizes), BMW_320I, blind
        )
        expected = smallest_distance(plan.trajectory, truth, BMW_320I)
        assert measured.smallest_distance[0] == pytest.approx(expected, abs=1e-9)
        assert measured.path_length[0] == pytest.approx(path_length(plan.trajectory))
        assert measured.cost_sm1[0] == pytest.approx(sm1_cost(plan.trajectory, blind))
        touches = first_contact(plan.trajectory, truth, BMW_320I) is not None
        assert touches == (expected == 0.0)
        touched += touches
    assert touched > 0


def test_random_rectangles_are_as_far_apart_as_shapely_finds() -> None:
    """Also where they cross without a corner of one in the other."""
    random = np.random.default_rng(3)
    count = 300
    states = np.zeros((count, 1, 5))
    poses = np.column_stack([random.uniform(-9, 9, (count, 2)), random.uniform(-4, 4, count)])
    sizes = random.uniform(0.2, 14.0, (count, 2))
    alone = np.ones(count, np.int64)
    laid = np.column_stack([poses[:, :2], np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    scenario = procedural_scenes(1).labelled[0].problem(Intention.STRAIGHT)
    measured = batch_measures(
        TrajectoryBatch(states, alone, laid[:, None, None], 0.5 * sizes[:, None]),
        BMW_320I,
        scenario,
    )
    own = rectangle_polygons(np.zeros((1, 3)), BMW_320I.length, BMW_320I.width)[0]
    others = rectangle_polygons(poses, sizes[:, 0], sizes[:, 1])
    expected = [own.distance(other) for other in others]
    np.testing.assert_allclose(measured.smallest_distance, expected, atol=1e-9)
    assert 0 < np.count_nonzero(measured.smallest_distance == 0) < count
