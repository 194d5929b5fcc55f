"""Oracles: projection by `avsec_gym.geometry`, finite differences, scipy's optimiser."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from avsec_gym.geometry import box_corners, project, wrap_angle
from avsec_gym.perception.detectors.stereo_rcnn.box_solver import (
    ObservedBoxes,
    _Problem,
    solve_boxes,
)
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera

LEFT = np.array([[720.0, 0, 620, 45], [0, 720, 180, 0.2], [0, 0, 1, 0.003]])
RIGHT = np.array([[720.0, 0, 620, -340], [0, 720, 180, 0.2], [0, 0, 1, 0.003]])
CAMERA = StereoCamera.of_projections(LEFT, RIGHT, (375, 1242))


def cars(count, seed, x=(-6, 6), z=(12, 45)):
    random = np.random.default_rng(seed)
    location = np.column_stack(
        [random.uniform(*x, count), random.uniform(1.5, 1.8, count), random.uniform(*z, count)]
    )
    dimensions = random.normal([1.5, 1.65, 4.0], [0.1, 0.1, 0.3], (count, 3))
    return location, dimensions, random.uniform(-np.pi, np.pi, count)


def observe(location, dimensions, rotation_y):
    """Boxes and the nearest bottom corner, from the eight projected corners; camera-0 locations."""
    corners = box_corners(location, dimensions, rotation_y)
    boxes = []
    for projection in (LEFT, RIGHT):
        pixels, _ = project(projection, corners)
        box = np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=1)
        boxes.append(np.clip(box, 0, [1241, 374, 1241, 374]))
    # Our rear left, front left, front right, rear right, found by where they are.
    across, ahead = np.array([-1, -1, 1, 1]), np.array([-1, 1, 1, -1])
    cos, sin = np.cos(rotation_y)[:, None], np.sin(rotation_y)[:, None]
    along = dimensions[:, 2:] / 2 * ahead
    beside = dimensions[:, 1:2] / 2 * across
    x = location[:, :1] + cos * along - sin * beside
    z = location[:, 2:] - sin * along - cos * beside
    bottom = np.stack([x, np.broadcast_to(location[:, 1:2], x.shape), z], axis=-1)
    u = project(LEFT, bottom)[0][..., 0]
    corner = z.argmin(axis=1)
    seen = location + CAMERA.offset
    return ObservedBoxes(
        boxes[0],
        boxes[1],
        u[np.arange(len(u)), corner],
        corner,
        boxes[0][:, [0, 2]],
        dimensions,
        wrap_angle(rotation_y - np.arctan2(seen[:, 0], seen[:, 2])),
    )


def keypoint_is_inside(observed):
    """Face-on cars have no keypoint: their yaw is not determined."""
    share = (observed.keypoint - observed.left[:, 0]) / np.ptp(observed.left[:, [0, 2]], axis=1)
    return (share > 0.03) & (share < 0.97)


def test_perfect_observations_give_the_box_itself():
    location, dimensions, rotation_y = cars(400, 0)
    observed = observe(location, dimensions, rotation_y)
    clear = keypoint_is_inside(observed) & (observed.left[:, 0] > 25) & (observed.left[:, 2] < 1215)
    solved = solve_boxes(observed, CAMERA)
    assert clear.sum() > 200
    error = np.abs(solved.location - CAMERA.offset - location)[clear]
    turned = np.abs(wrap_angle(solved.rotation_y - rotation_y))[clear]
    assert solved.valid[clear].all()
    assert np.mean((error.max(axis=1) < 0.02) & (turned < 0.01)) > 0.97


def test_a_pixel_of_noise_costs_little():
    location, dimensions, rotation_y = cars(400, 1, z=(10, 25))
    observed = observe(location, dimensions, rotation_y)
    clear = keypoint_is_inside(observed)
    noise = np.random.default_rng(1).normal(0, 1, (400, 9))
    noisy = replace(
        observed,
        left=observed.left + noise[:, :4],
        right=observed.right + noise[:, 4:8],
        keypoint=observed.keypoint + noise[:, 8],
    )
    solved = solve_boxes(noisy, CAMERA)
    error = np.abs(solved.location - CAMERA.offset - location)[clear]
    turned = np.abs(wrap_angle(solved.rotation_y - rotation_y))[clear]
    assert (np.median(error, axis=0) < [0.12, 0.05, 0.4]).all()
    assert np.median(turned) < 0.03


def test_truncated_cars_are_solved_by_angle_and_right_view():
    location, dimensions, rotation_y = cars(200, 2, x=(-7, -5), z=(6, 9))
    observed = observe(location, dimensions, rotation_y)
    cut = (observed.left[:, 0] == 0) & (observed.left[:, 2] > 120) & (observed.right[:, 2] > 60)
    cut &= observed.left[:, 3] < 360
    nonsense = replace(observed, keypoint=np.full(200, 77.0), corner=np.zeros(200, int))
    solved = solve_boxes(nonsense, CAMERA)
    error = np.abs(solved.location - CAMERA.offset - location)[cut]
    assert cut.sum() > 20
    assert np.median(error.max(axis=1)) < 0.02


def test_a_known_depth_is_kept():
    location, dimensions, rotation_y = cars(100, 3)
    observed = observe(location, dimensions, rotation_y)
    depth = location[:, 2] + CAMERA.offset[2]
    solved = solve_boxes(observed, CAMERA, depth)
    clear = keypoint_is_inside(observed) & (observed.left[:, 0] > 25) & (observed.left[:, 2] < 1215)
    np.testing.assert_array_equal(solved.location[:, 2], depth)
    error = np.abs(solved.location - CAMERA.offset - location)[clear]
    assert np.quantile(error.max(axis=1), 0.95) < 0.02


@pytest.mark.parametrize("known", [False, True])
def test_the_derivatives_are_those_of_the_residuals(known):
    location, dimensions, rotation_y = cars(60, 4, x=(-12, 12), z=(6, 40))
    observed = observe(location, dimensions, rotation_y)
    problem = _Problem(observed, CAMERA, location[:, 2] if known else None)
    state = np.column_stack([location, rotation_y + np.pi / 2]) + 0.1
    slopes = problem.residuals(state)[1]
    for i in range(4):
        step = np.zeros(4)
        step[i] = 0.0 if known and i == 2 else 1e-6
        ahead, behind = (problem.residuals(state + sign * step)[0] for sign in (1, -1))
        np.testing.assert_allclose(slopes[:, :, i], (ahead - behind) / 2e-6, atol=1e-6)


def test_scipy_finds_no_better_box():
    location, dimensions, rotation_y = cars(30, 5)
    observed = observe(location, dimensions, rotation_y)
    shaken = replace(
        observed, left=observed.left + np.random.default_rng(5).normal(0, 1.5, (30, 4))
    )
    solved = solve_boxes(shaken, CAMERA)
    problem = _Problem(shaken, CAMERA, None)
    state = np.column_stack([solved.location, solved.rotation_y + np.pi / 2])
    problem.take_extreme_corners(state)
    for i in np.flatnonzero(keypoint_is_inside(shaken)):

        def residuals(one, i=i):
            return problem.residuals(np.where(np.arange(30)[:, None] == i, one, state))[0][i]

        ours = (residuals(state[i]) ** 2).sum()
        assert ours <= 2 * least_squares(residuals, state[i]).cost * 1.05 + 1e-9


def test_what_cannot_be_solved_says_so():
    location, dimensions, rotation_y = cars(3, 6)
    observed = observe(location, dimensions, rotation_y)
    hidden = replace(observed, borders=observed.borders[:, [0, 0]] + [0, 2])
    tiny = replace(observed, left=observed.left[:, [0, 1, 0, 1]] + [0, 0, 9, 30])
    far = replace(observed, dimensions=10 * observed.dimensions)
    for case in (hidden, tiny, far):
        assert not solve_boxes(case, CAMERA).valid.any()
    assert len(solve_boxes(observed[:0], CAMERA).valid) == 0
