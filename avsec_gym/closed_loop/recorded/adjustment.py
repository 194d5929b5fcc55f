"""Poses of a car and places of standing objects, fitted together (planar bundle adjustment).

Gauss and Newton's method on sparse matrices.  A label is seen from a pose; weights let wrong labels
go (Geman and McClure).  What a car cannot do counts, too: its rear axle does not slip sideways, its
acceleration does not jump.  Where nothing is seen, a first guess holds loosely.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from avsec_gym.closed_loop.recorded.recorded_traffic import RecordedObject, world_poses
from avsec_gym.geometry import Floats, wrap_angle

REAR_AXLE = 1.1
"""Metres from KITTI's camera back to the rear axle."""
_NOISE, _NOISE_PER_METRE, _NOISE_OF_HEADING = 0.08, 0.006, 0.03
"""Standard deviations of labels: m, m for each m of distance, rad."""
_CUT = 3.0
"""Standard deviations beyond which a label loses its weight."""
_SLIP, _JERK, _TURNING = 0.01, 0.01, 0.008
"""Standard deviations of the car's sideways slip (m a step), of the third difference of its places
(m a step^3) and of the second difference of its headings (rad a step^2)."""
_WAY, _TURN = 0.15, 0.02
"""Standard deviations of the first guess: m and rad from frame to frame."""


def fitted(
    poses: Floats, standing: list[RecordedObject], guess: Floats, most: int = 15
) -> tuple[Floats, Floats]:
    """Poses of the car and places of standing objects that fit all labels best (Gauss-Newton).

    Args:
        poses: Where the fit begins, shape (T, 3); the first pose stays where it is.
        standing: The objects that stand.
        guess: A motion that holds, loosely, where no standing object is seen, shape (T, 3).
        most: Most steps.

    Returns:
        The poses, shape (T, 3), and the places, shape (N, 3).
    """
    if not standing:
        return poses, np.zeros((0, 3))
    poses, count = poses.copy(), len(poses)
    places = np.array([np.median(world_poses(each, poses), axis=0) for each in standing])
    frames = np.concatenate([each.frames for each in standing])
    owner = np.repeat(np.arange(len(standing)), [len(each.frames) for each in standing])
    seen = np.vstack([each.poses for each in standing])
    noise = _NOISE + _NOISE_PER_METRE * np.hypot(seen[:, 0], seen[:, 1])
    for _ in range(most):
        rows = [
            _labels_part(poses, places, frames, owner, seen, noise),
            _motion_part(poses, len(standing)),
            _guess_part(poses, guess, len(standing)),
        ]
        jacobian = sparse.vstack([part[0] for part in rows]).tocsc()
        residual = np.concatenate([part[1] for part in rows])
        # The first pose is held: its columns are left out.
        free = jacobian[:, 3:]
        normal = (free.T @ free + 1e-9 * sparse.identity(free.shape[1])).tocsc()
        step = np.concatenate([np.zeros(3), spsolve(normal, -(free.T @ residual))])
        poses += step[: 3 * count].reshape(count, 3)
        places += step[3 * count :].reshape(-1, 3)
        if np.abs(step).max() < 1e-4:
            break
    return poses, places


def _labels_part(
    poses: Floats,
    places: Floats,
    frames: NDArray[np.int64],
    owner: NDArray[np.int64],
    seen: Floats,
    noise: Floats,
) -> tuple[sparse.coo_array, Floats]:
    """Jacobian and residuals of the labels: where a place is seen from a pose, less the label."""
    own, place = poses[frames], places[owner]
    cos, sin = np.cos(own[:, 2]), np.sin(own[:, 2])
    apart = place[:, :2] - own[:, :2]
    x = cos * apart[:, 0] + sin * apart[:, 1]
    y = cos * apart[:, 1] - sin * apart[:, 0]
    off = np.column_stack([x - seen[:, 0], y - seen[:, 1]]) / noise[:, None]
    turned = wrap_angle(place[:, 2] - own[:, 2] - seen[:, 2]) / _NOISE_OF_HEADING
    weight = 1.0 / (1.0 + ((off**2).sum(axis=1)) / _CUT**2)
    weight_turned = 1.0 / (1.0 + (turned / _CUT) ** 2)
    n, start = len(seen), 3 * len(poses)
    row, scale = np.arange(n), weight / noise
    car, thing = 3 * frames, start + 3 * owner
    # Rows: n along the car's x axis, n along its y axis, n headings.
    entries = [
        (row, car, -cos * scale),
        (row, car + 1, -sin * scale),
        (row, car + 2, y * scale),
        (row, thing, cos * scale),
        (row, thing + 1, sin * scale),
        (row + n, car, sin * scale),
        (row + n, car + 1, -cos * scale),
        (row + n, car + 2, -x * scale),
        (row + n, thing, -sin * scale),
        (row + n, thing + 1, cos * scale),
        (row + 2 * n, car + 2, -weight_turned / _NOISE_OF_HEADING),
        (row + 2 * n, thing + 2, weight_turned / _NOISE_OF_HEADING),
    ]
    jacobian = _matrix(entries, (3 * n, start + 3 * len(places)))
    residual = np.concatenate([off[:, 0] * weight, off[:, 1] * weight, turned * weight_turned])
    return jacobian, residual


def _motion_part(poses: Floats, things: int) -> tuple[sparse.coo_array, Floats]:
    """Jacobian and residuals of what a car cannot do."""
    count = len(poses)
    columns = 3 * count + 3 * things
    x, y, heading = poses.T
    # Slip: the rear axle's way from frame to frame, across the mean heading.
    middle = 0.5 * (heading[1:] + heading[:-1])
    cos, sin = np.cos(middle), np.sin(middle)
    dx = np.diff(x) - REAR_AXLE * np.diff(np.cos(heading))
    dy = np.diff(y) - REAR_AXLE * np.diff(np.sin(heading))
    slip = (cos * dy - sin * dx) / _SLIP
    half = -0.5 * (cos * dx + sin * dy) / _SLIP
    # Of the rear axle's own way, across the mean heading, a turn moves it by its lever.
    lever = REAR_AXLE * np.cos(0.5 * np.diff(heading)) / _SLIP
    first = np.arange(count - 1)
    one = np.ones(count - 1) / _SLIP
    slip_entries = [
        (first, 3 * first, sin * one),
        (first, 3 * first + 3, -sin * one),
        (first, 3 * first + 1, -cos * one),
        (first, 3 * first + 4, cos * one),
        (first, 3 * first + 2, half + lever),
        (first, 3 * first + 5, half - lever),
    ]
    parts = [(_matrix(slip_entries, (count - 1, columns)), slip)]
    for axis, stencil, spread in (
        (0, (-1.0, 3.0, -3.0, 1.0), _JERK),
        (1, (-1.0, 3.0, -3.0, 1.0), _JERK),
        (2, (1.0, -2.0, 1.0), _TURNING),
    ):
        n = count - len(stencil) + 1
        at = np.arange(n)
        entries = [(at, 3 * (at + i) + axis, np.full(n, s / spread)) for i, s in enumerate(stencil)]
        value = sum(s * poses[i : i + n, axis] for i, s in enumerate(stencil)) / spread
        parts.append((_matrix(entries, (n, columns)), np.asarray(value)))
    return sparse.vstack([part[0] for part in parts]), np.concatenate([part[1] for part in parts])


def _guess_part(poses: Floats, guess: Floats, things: int) -> tuple[sparse.coo_array, Floats]:
    """Jacobian and residuals of the way and the turn from frame to frame, against a guess."""
    count = len(poses)
    x, y, heading = poses.T
    middle = 0.5 * (heading[1:] + heading[:-1])
    cos, sin = np.cos(middle), np.sin(middle)
    dx, dy = np.diff(x), np.diff(y)
    way = cos * dx + sin * dy
    guessed_middle = 0.5 * (guess[1:, 2] + guess[:-1, 2])
    guessed = np.cos(guessed_middle) * np.diff(guess[:, 0])
    guessed += np.sin(guessed_middle) * np.diff(guess[:, 1])
    half = 0.5 * (cos * dy - sin * dx) / _WAY
    at = np.arange(count - 1)
    one, turn = np.ones(count - 1) / _WAY, np.ones(count - 1) / _TURN
    entries = [
        (at, 3 * at, -cos * one),
        (at, 3 * at + 1, -sin * one),
        (at, 3 * at + 3, cos * one),
        (at, 3 * at + 4, sin * one),
        (at, 3 * at + 2, half),
        (at, 3 * at + 5, half),
        (at + count - 1, 3 * at + 2, -turn),
        (at + count - 1, 3 * at + 5, turn),
    ]
    off = [(way - guessed) / _WAY, (np.diff(heading) - np.diff(guess[:, 2])) / _TURN]
    return _matrix(entries, (2 * (count - 1), 3 * count + 3 * things)), np.concatenate(off)


def _matrix(
    entries: list[tuple[NDArray[np.int64], NDArray[np.int64], Floats]], shape: tuple[int, int]
) -> sparse.coo_array:
    rows, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
    return sparse.coo_array((values, (rows, columns)), shape=shape)
