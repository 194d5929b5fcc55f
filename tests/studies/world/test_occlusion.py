"""Thresholds from annotated levels."""

from __future__ import annotations

import numpy as np
import pytest

from studies.world.occlusion import agreement, choose_thresholds, levels


def test_levels_fall_with_the_seen_share() -> None:
    shares = np.array([1.0, 0.95, 0.7, 0.5, 0.0])
    assert levels(shares, (0.9, 0.6)).tolist() == [0, 0, 1, 2, 2]


def test_the_annotators_own_thresholds_are_found() -> None:
    rng = np.random.default_rng(0)
    share = rng.random(3000)
    judged = levels(share, (0.80, 0.35))
    first, second = choose_thresholds(share, judged)
    assert first == pytest.approx(0.80, abs=0.011)
    assert second == pytest.approx(0.35, abs=0.011)
    perfect = agreement(share, judged, (0.80, 0.35))
    assert perfect.agreement == 1.0
    assert perfect.kappa == pytest.approx(1.0)


def test_chance_is_no_agreement() -> None:
    rng = np.random.default_rng(1)
    result = agreement(rng.random(6000), rng.integers(0, 3, 6000), (0.66, 0.33))
    assert abs(result.kappa) < 0.05
    assert np.sum(result.confusion) == 6000
