"""Measured poses: errors of the asked size, which drift along a drive."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.world.export.measured_poses import clock_offsets, measured_pose, pose_errors


def test_errors_have_the_asked_spread_at_every_frame() -> None:
    errors = np.stack([pose_errors(5, drive, 1, 30) for drive in range(1500)])
    np.testing.assert_allclose(errors.mean(axis=0), 0.0, atol=0.12)
    np.testing.assert_allclose(errors.std(axis=0), 1.0, atol=0.08)
    pose = np.eye(4)
    pose[:3, 3] = 30.0, -4.0, 1.73
    measured = np.stack([measured_pose(pose, error[7], 0.2, 0.5) for error in errors])
    away = measured[:, :3, 3] - pose[:3, 3]
    assert away[:, :2].std(axis=0) == pytest.approx([0.2, 0.2], rel=0.06)
    np.testing.assert_array_equal(away[:, 2], 0.0)
    heading = np.degrees(np.arctan2(measured[:, 1, 0], measured[:, 0, 0]))
    assert heading.std() == pytest.approx(0.5, rel=0.06)


def test_errors_drift_and_do_not_depend_on_the_length_of_a_drive() -> None:
    errors = np.stack([pose_errors(5, drive, 0, 101) for drive in range(400)])[..., 0]
    one_second = np.corrcoef(errors[:, 20], errors[:, 30])[0, 1]
    assert one_second == pytest.approx(np.exp(-0.2), abs=0.08)
    assert abs(np.corrcoef(errors[:, 0], errors[:, 100])[0, 1]) < 0.3
    np.testing.assert_array_equal(pose_errors(5, 3, 0, 4), pose_errors(5, 3, 0, 9)[:4])
    assert not np.array_equal(pose_errors(5, 3, 0, 4), pose_errors(5, 3, 1, 4))


def test_without_noise_the_measured_pose_is_the_true_one() -> None:
    pose = np.eye(4)
    pose[:3, 3] = 1.0, 2.0, 3.0
    error = np.array([1.0, -1.0, 2.0])
    np.testing.assert_array_equal(measured_pose(pose, error, 0.0, 0.0), pose)


def test_clocks_are_as_far_apart_as_asked() -> None:
    offsets = np.stack([clock_offsets(1, drive, 4, 0.1) for drive in range(200)])
    assert offsets.min() >= 0.0
    assert offsets.max() <= 0.1
    assert np.ptp(offsets, axis=1).mean() == pytest.approx(0.06, abs=0.01)
    np.testing.assert_array_equal(clock_offsets(1, 0, 3, 0.0), 0.0)
