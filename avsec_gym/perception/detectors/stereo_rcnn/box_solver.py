"""From what two views show of a box to the box: x, y, z and yaw (Li et al. 2019, section 4).

A 3D box of known size explains a left and a right 2D box, one of its four bottom corners in the
left image (the perspective keypoint) and, where the image cuts it off, its observation angle.
The pose with the least squared difference is found by Levenberg-Marquardt steps with an analytic
Jacobian, for all boxes at once.

Inside, a box's own axes are a along its width and b along its length, and theta turns b into
the camera's z: ``X = x + cos a + sin b``, ``Z = z - sin a + cos b``, ``theta = rotation_y + pi/2``.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera

Indices = NDArray[np.intp]

CORNERS = np.array([[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]])
"""Shares of width and length: rear left, front left, front right, rear right, as the keypoints."""

_FARTHEST = 100.0
_SMALLEST_BOX, _SMALLEST_VISIBLE = 10.0, 3.0
_SIDE_MARGIN, _TOP_MARGIN = 20.0, 10.0
_KEYPOINT_WEIGHT = 2.0
_STEPS = 40

_STRAIGHT = np.deg2rad(4.0)
# Corner at the left, right, bottom of the 2D box: seen along a side (odd rows: obliquely), for
# observation angles from -90 degrees downwards in steps of 45.
_VIEWPOINTS = np.array(
    [[0, 3, 3], [1, 3, 0], [1, 0, 0], [2, 0, 1], [2, 1, 1], [3, 1, 2], [3, 2, 2], [0, 2, 3]]
)


@dataclass(frozen=True, eq=False)
class ObservedBoxes:
    """What the network predicts of N cars, in pixels of the camera's images.

    Args:
        left: 2D boxes in the left image, shape (N, 4): left, top, right, bottom.
        right: The same in the right image.
        keypoint: Where the keypoint is in the left image, u, shape (N,).
        corner: The bottom corner that it is, 0..3 as in `CORNERS`, shape (N,).
        borders: First and last visible column in the left image, shape (N, 2).
        dimensions: Height, width, length, metres, shape (N, 3).
        alpha: Observation angle, shape (N,).
    """

    left: Floats
    right: Floats
    keypoint: Floats
    corner: Indices
    borders: Floats
    dimensions: Floats
    alpha: Floats

    def __len__(self) -> int:
        return len(self.left)

    def __getitem__(self, index: Any) -> ObservedBoxes:
        return ObservedBoxes(*(getattr(self, field.name)[index] for field in fields(self)))


@dataclass(frozen=True, eq=False)
class SolvedBoxes:
    """Poses in the left camera's frame.

    Args:
        location: Bottom centres, shape (N, 3), metres.
        rotation_y: Yaw as in KITTI, shape (N,).
        valid: Whether the observation was fit for a solution and the result is, shape (N,).
    """

    location: Floats
    rotation_y: Floats
    valid: NDArray[np.bool_]

    def __getitem__(self, index: Any) -> SolvedBoxes:
        return SolvedBoxes(*(getattr(self, field.name)[index] for field in fields(self)))


def solve_boxes(
    observed: ObservedBoxes, camera: StereoCamera, depth: Floats | None = None
) -> SolvedBoxes:
    """The boxes that explain the observations best.

    Args:
        observed: N boxes.
        camera: The camera that saw them.
        depth: The known z of the centres, shape (N,); x, y and yaw are solved then.
    """
    problem = _Problem(observed, camera, depth)
    state = problem.initial_state()
    state = _minimise(problem, state)
    # The viewpoint's corners are right for far boxes: from the box found, the true ones are known.
    problem.take_extreme_corners(state)
    state = _minimise(problem, state)
    size = observed.left[:, 2:] - observed.left[:, :2]
    visible = observed.borders[:, 1] - observed.borders[:, 0]
    valid = (visible >= _SMALLEST_VISIBLE) & (size >= _SMALLEST_BOX).all(axis=1)
    valid &= (state[:, 2] > 0) & (state[:, 2] <= _FARTHEST) & np.isfinite(state).all(axis=1)
    return SolvedBoxes(state[:, :3], wrap_angle(state[:, 3] - np.pi / 2), valid)


class _Problem:
    """Residuals (N, 8) of states (N, 4): x, y, z, theta.

    The terms: left and right edge, keypoint, bottom, top of the left box, left and right edge of
    the right box (all on the plane one metre ahead), observation angle.
    """

    def __init__(self, observed: ObservedBoxes, camera: StereoCamera, depth: Floats | None) -> None:
        left, right = observed.left, observed.right
        height, width = camera.size
        self.observed, self.camera, self.depth = observed, camera, depth
        # Of a box that the image cuts off, the keypoint is unknown: the network's angle stands in.
        truncated = (left[:, 0] < _SIDE_MARGIN) | (left[:, 2] > width - _SIDE_MARGIN)
        self.alpha = np.where(truncated, observed.alpha, _alpha_of_keypoint(observed))
        self.corners = np.column_stack([_viewpoint_corners(self.alpha), observed.corner])
        # What was observed, in the order of the terms, on the plane one metre ahead.
        top_left, bottom_right = camera.rays(left[:, :2]), camera.rays(left[:, 2:])
        keypoint = camera.rays(np.column_stack([observed.keypoint, left[:, 1]]))
        right_left, right_right = camera.rays(right[:, :2]), camera.rays(right[:, 2:])
        self.edges = np.column_stack(
            [
                top_left[:, 0],
                bottom_right[:, 0],
                keypoint[:, 0],
                bottom_right[:, 1],
                top_left[:, 1],
                right_left[:, 0],
                right_right[:, 0],
            ]
        )
        # An edge on the image's border is no edge of the object, and has no weight.
        seen_by_right = truncated & (depth is None)
        self.weights = np.column_stack(
            [
                left[:, 0] >= _SIDE_MARGIN,
                left[:, 2] <= width - _SIDE_MARGIN,
                _KEYPOINT_WEIGHT * ~truncated,
                left[:, 3] <= height - _TOP_MARGIN,
                left[:, 1] >= _TOP_MARGIN,
                seen_by_right & (right[:, 0] >= _SIDE_MARGIN),
                seen_by_right & (right[:, 2] <= width - _SIDE_MARGIN),
                truncated,
            ]
        ).astype(float)

    def initial_state(self) -> Floats:
        disparity = (self.observed.left - self.observed.right)[:, [0, 2]].mean(axis=1)
        nearest = self.camera.focal_times_baseline / np.maximum(disparity, 1.0)
        z = nearest if self.depth is None else self.depth
        x = z * (self.edges[:, 0] + self.edges[:, 1]) / 2
        y = z * (self.edges[:, 3] + self.edges[:, 4]) / 2 + self.observed.dimensions[:, 0] / 2
        return np.column_stack([x, y, z, self.alpha + np.pi / 2 + np.arctan2(x, z)])

    def take_extreme_corners(self, state: Floats) -> None:
        """Take the corners at the ends of the box of `state`, by what both cameras see of it."""
        x, z = self._corner_positions(state, np.tile(np.arange(4), (len(state), 1)))
        u = x / z
        below = state[:, 1] > self.observed.dimensions[:, 0]
        nearest, farthest = z.argmin(axis=1), z.argmax(axis=1)
        self.corners = np.column_stack(
            [
                u.argmin(axis=1),
                u.argmax(axis=1),
                nearest,
                np.where(below, farthest, nearest),
                self.observed.corner,
            ]
        )

    def residuals(self, state: Floats) -> tuple[Floats, Floats]:
        """Residuals (N, 8) and their derivatives (N, 8, 4)."""
        left, right, bottom, top, keypoint = range(5)
        picked = [left, right, keypoint, bottom, top, left, right]
        x, z = self._corner_positions(state, self.corners[:, picked])
        count = len(state)
        numerator, slope = x.copy(), np.zeros((count, 7, 4))
        slope[:, :, 0] = 1.0
        slope[:, :, 3] = z - state[:, None, 2]
        numerator[:, 5:] -= self.camera.baseline
        numerator[:, 3], numerator[:, 4] = state[:, 1], state[:, 1] - self.observed.dimensions[:, 0]
        slope[:, 3:5] = [0.0, 1.0, 0.0, 0.0]
        ratio = numerator / z
        slope[:, :, 2] -= ratio
        slope[:, :, 3] += ratio * (x - state[:, None, 0])
        angle = state[:, 3] - np.pi / 2 - np.arctan2(state[:, 0], state[:, 2])
        square = state[:, 0] ** 2 + state[:, 2] ** 2
        turn = np.column_stack(
            [-state[:, 2] / square, np.zeros(count), state[:, 0] / square, np.ones(count)]
        )
        terms = np.column_stack([ratio - self.edges, wrap_angle(angle - self.alpha)])
        slopes = np.concatenate([slope / z[:, :, None], turn[:, None]], axis=1)
        if self.depth is not None:
            slopes[:, :, 2] = 0.0
        return terms * self.weights, slopes * self.weights[:, :, None]

    def _corner_positions(self, state: Floats, corners: Indices) -> tuple[Floats, Floats]:
        """Camera x and z, each (N, K), of the corners (N, K)."""
        across, along = np.moveaxis(CORNERS[corners] * self.observed.dimensions[:, None, 1:], 2, 0)
        cos, sin = np.cos(state[:, 3:]), np.sin(state[:, 3:])
        x = state[:, :1] + cos * across + sin * along
        z = state[:, 2:3] - sin * across + cos * along
        return x, np.maximum(z, 0.1)


def _minimise(problem: _Problem, state: Floats) -> Floats:
    """Levenberg-Marquardt, each box with its own damping."""
    damping = np.full(len(state), 1e-3)
    terms, slopes = problem.residuals(state)
    cost = (terms**2).sum(axis=1)
    for _ in range(_STEPS):
        normal = np.einsum("nki,nkj->nij", slopes, slopes)
        gradient = np.einsum("nki,nk->ni", slopes, terms)
        scale = np.einsum("nii->ni", normal)
        ridge = damping[:, None] * scale + 1e-12
        step = np.linalg.solve(normal + ridge[:, :, None] * np.eye(4), -gradient[:, :, None])[
            ..., 0
        ]
        candidate = state + step
        new_terms, new_slopes = problem.residuals(candidate)
        new_cost = (new_terms**2).sum(axis=1)
        better = new_cost < cost
        damping = np.where(better, np.maximum(damping / 5, 1e-9), damping * 5)
        state = np.where(better[:, None], candidate, state)
        terms = np.where(better[:, None], new_terms, terms)
        slopes = np.where(better[:, None, None], new_slopes, slopes)
        cost = np.where(better, new_cost, cost)
        if (np.abs(step) < 1e-5).all():
            break
    return state


def _alpha_of_keypoint(observed: ObservedBoxes) -> Floats:
    """Observation angle from where in the 2D box which corner is; good enough for a viewpoint."""
    width = np.maximum(observed.left[:, 2] - observed.left[:, 0], 1e-6)
    share = np.clip((observed.keypoint - observed.left[:, 0]) / width, -1, 1)
    start = np.array([-np.pi / 2, np.pi, np.pi / 2, 0.0])[observed.corner]
    return wrap_angle(start - np.arcsin(share))


def _viewpoint_corners(alpha: Floats) -> Indices:
    """Corners (N, 4) at the left, right, bottom and top of the 2D box, by viewpoint."""
    quarter = np.round((-np.pi / 2 - alpha) / (np.pi / 2))
    rest = -np.pi / 2 - alpha - quarter * np.pi / 2
    oblique = np.where(rest > _STRAIGHT, 1, np.where(rest < -_STRAIGHT, -1, 0))
    left, right, bottom = _VIEWPOINTS[((2 * quarter + oblique) % 8).astype(int)].T
    return np.column_stack([left, right, bottom, (bottom + 2) % 4])
