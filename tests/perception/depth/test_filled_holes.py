"""Filled holes, against a slow fill by hand and by scipy; and as a depth of pairs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import interp1d

from avsec_gym.errors import ConfigurationError
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.perception.depth.filled_holes import FilledHoles, filled_holes
from avsec_gym.rig import kitti_rig
from avsec_gym.validation.evidence.pair_depth import PairDepth, WholeWidthMatching


def by_scipy(disparity: Disparity) -> Disparity:
    """Of each row the smaller of the known pixels to the left and to the right; rows from above."""
    result = np.full_like(disparity, np.nan)
    columns = np.arange(disparity.shape[1])
    for row, values in enumerate(disparity):
        known = np.flatnonzero(np.isfinite(values))
        if not len(known):
            continue
        ends = values[known[0]], values[known[-1]]
        # `interp1d` takes two places or more.
        places, at = np.r_[-1, known, len(values)], np.r_[ends[0], values[known], ends[1]]
        left, right = (interp1d(places, at, kind=kind)(columns) for kind in ("previous", "next"))
        result[row] = np.minimum(left, right)
    whole = np.flatnonzero(np.isfinite(result).all(axis=1))
    for row in range(len(result)):
        above = whole[whole <= row]
        result[row] = result[above[-1] if len(above) else whole[0]]
    return result


@pytest.mark.parametrize("known", [0.02, 0.3, 0.9])
def test_filled_as_by_scipy(known: float) -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        shape = rng.integers(2, 40, 2)
        values = rng.uniform(1, 90, shape).astype(np.float32)
        holes = np.where(rng.random(shape) < known, values, np.float32(np.nan))
        holes[rng.random(shape[0]) < 0.3] = np.nan
        if np.isfinite(holes).any():
            np.testing.assert_array_equal(filled_holes(holes), by_scipy(holes))


def test_what_is_known_stays_and_nothing_gives_nothing() -> None:
    values = np.arange(1, 13, dtype=np.float32).reshape(3, 4)
    np.testing.assert_array_equal(filled_holes(values), values)
    assert np.isnan(filled_holes(np.full((3, 4), np.nan, np.float32))).all()
    assert filled_holes(np.zeros((0, 4), np.float32)).shape == (0, 4)


def test_a_depth_of_pairs_fills_the_holes_of_its_matcher() -> None:
    calibration = kitti_rig().calibration
    plain, filled = PairDepth(), PairDepth({"name": "sgbm", "filled": True})
    estimator = filled.estimator(calibration, 2, 3)
    assert isinstance(estimator, FilledHoles)
    assert estimator.estimator == plain.estimator(calibration, 2, 3)
    assert isinstance(estimator.estimator, WholeWidthMatching)
    # What was fitted with one holds for the other as little as for another matcher.
    assert filled.settings != plain.settings
    assert PairDepth.from_settings(filled.settings) == filled
    assert not isinstance(
        PairDepth({"name": "sgbm", "filled": False}).estimator(calibration, 2, 3), FilledHoles
    )
    chosen = PairDepth({"name": "sgbm", "filled": True, "disparities": 64})
    found = chosen.estimator(calibration, 2, 3)
    assert isinstance(found, FilledHoles)
    with pytest.raises(ConfigurationError, match="filled"):
        PairDepth({"name": "sgbm", "filled": "yes"})
    with pytest.raises(ConfigurationError, match="filled"):
        PairDepth({"name": "psmnet", "filled": True}).estimator(calibration, 2, 3)
