"""Noise of ranges, and how even the ground is, on scans of which both are known."""

from __future__ import annotations

import numpy as np
import pytest

from studies.world.scan_ranges import STEP, ground_residual, range_noise


def test_noise_is_found_on_a_slanting_wall() -> None:
    """The wall itself adds nothing."""
    azimuth = STEP * np.arange(-400, 400)
    rng = np.random.default_rng(0)
    distance = 12.0 / np.cos(azimuth - 0.5) + rng.normal(0.0, 0.02, len(azimuth))
    points = np.column_stack(
        [distance * np.cos(azimuth), distance * np.sin(azimuth), 0 * azimuth, 0 * azimuth]
    ).astype(np.float32)
    beam = np.zeros(len(points), np.int64)
    assert range_noise(points, beam, 5.0, 30.0) == pytest.approx(0.02, rel=0.1)
    assert range_noise(points, beam, 90.0, 95.0) is None


def test_slopes_are_even_and_steps_are_not() -> None:
    rng = np.random.default_rng(0)
    places = rng.uniform([-20, -3.9], [20, 3.9], (40_000, 2))
    height = -1.73 + 0.01 * places[:, 0] + rng.normal(0.0, 0.01, len(places))
    points = np.column_stack([places, height, 0 * height]).astype(np.float32)
    median, worst = ground_residual(points, 2.0) or (0.0, 0.0)
    assert median == pytest.approx(0.01, rel=0.05)
    assert worst < 0.012
    points[points[:, 1] > 3.0, 2] += 0.15
    median, worst = ground_residual(points, 2.0) or (0.0, 0.0)
    assert median == pytest.approx(0.01, rel=0.05)
    assert worst > 0.03
    assert ground_residual(points[:5], 2.0) is None
