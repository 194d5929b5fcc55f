"""How hard pairs are for a plain matcher."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.rig import kitti_rig
from studies.world.stereo import (
    MatcherErrors,
    RenderedPair,
    compare,
    match,
    scan_disparity,
    summary,
)


def test_a_shifted_texture_is_matched_to_its_shift() -> None:
    rng = np.random.default_rng(0)
    wide = np.repeat(rng.integers(0, 256, (120, 420, 1), np.uint8), 3, axis=2)
    found = match(wide[:, :400], wide[:, 20:])
    result = compare(found, np.full((120, 400), 20.0, np.float32))
    assert result.wrong == 0.0
    assert (result.density or 0.0) > 0.95
    assert result.median_error is not None
    assert result.median_error < 0.1


def test_errors_count_only_when_large_and_where_both_are_known() -> None:
    truth = np.full((1, 140), np.nan, np.float32)
    truth[0, 120:] = 100.0  # ten of them lie left of the first column that counts
    found = truth.copy()
    found[0, 130] = 104.0  # more than 3 pixels, less than 5 %
    found[0, 131] = 106.0
    found[0, 132] = np.nan
    result = compare(found, truth)
    assert result.pixels == 10
    assert result.density == pytest.approx(0.9)
    assert result.wrong == pytest.approx(1 / 9)


def test_the_nearest_point_of_a_pixel_wins_and_says_its_disparity() -> None:
    calibration = kitti_rig().calibration
    camera = np.array([[0.0, 0.0, 10.0, 1.0], [0.0, 0.0, 20.0, 1.0], [0.0, 0.0, -5.0, 1.0]])
    points = (camera @ calibration.camera_to_velodyne.T).astype(np.float32)
    disparity = scan_disparity(points, calibration, (375, 1242), (2, 3))
    known = np.isfinite(disparity)
    shift = calibration.focal_length(2) * calibration.baseline(2, 3)
    # Seen from camera 2, the two points ahead fall into different pixels.
    assert known.sum() == 2
    assert np.nanmax(disparity) == pytest.approx(shift / 10.0, rel=1e-3)
    both = np.concatenate([points[:1], points[:1] * np.float32([2, 2, 2, 1])])
    assert np.isfinite(scan_disparity(both, calibration, (375, 1242), (2, 3))).sum() >= 1


def test_summary_of_pairs_without_truth_is_unknown_not_perfect() -> None:
    pair = MatcherErrors(None, None, 0.9, None, None, 0)
    result = summary([RenderedPair(pair, pair)], {})
    assert result.lidar.wrong.p50 is None
    assert result.lidar.filled.p50 == pytest.approx(0.9)
