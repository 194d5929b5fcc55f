"""Semi-global matching, and the interface of all depth estimators."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.depth.depth import DepthEstimator, DisparityMap, make_depth
from avsec_gym.perception.depth.sgbm import SemiGlobalMatching
from avsec_gym.rig import kitti_rig


def wall(disparity: int) -> SensorFrame:
    """A textured wall that faces the cameras."""
    texture = np.random.default_rng(0).integers(0, 256, (120, 600 + disparity, 1), np.uint8)
    image = np.repeat(texture, 3, axis=2)
    views = {2: image[:, :600], 3: image[:, disparity : 600 + disparity]}
    return SensorFrame("000000", kitti_rig().calibration, views)


def test_a_wall_is_found_at_its_depth() -> None:
    frame = wall(32)
    found = SemiGlobalMatching().disparity(frame)
    inner = found.values[10:-10, 140:-10]
    assert found.valid[10:-10, 140:-10].mean() > 0.98
    assert np.nanmedian(inner) == pytest.approx(32, abs=0.1)
    calibration = frame.calibration
    depth = calibration.focal_length(2) * calibration.baseline(2, 3) / 32
    assert np.nanmedian(found.depth) == pytest.approx(depth, rel=5e-3)


def test_unknown_is_nan_and_never_zero() -> None:
    frame = wall(32)
    other = np.random.default_rng(1).integers(0, 256, frame.image(3).shape, np.uint8)
    found = SemiGlobalMatching().disparity(frame.with_image(3, other))
    assert found.valid.mean() < 0.2
    assert np.isnan(found.values[~found.valid]).all()
    assert np.isnan(found.depth[~found.valid]).all()


def test_rescaled_map_has_the_same_depths() -> None:
    found = DisparityMap(np.array([[10.0, np.nan]], np.float32), 400.0)
    other = found.rescaled(100.0)
    assert other.values[0, 0] == pytest.approx(2.5)
    np.testing.assert_allclose(other.depth, found.depth)


def test_makes_estimators_by_name() -> None:
    assert make_depth() == SemiGlobalMatching()
    for name in ("sgbm", "lidar", "ground_truth"):
        made = make_depth(name)
        assert isinstance(made, DepthEstimator)
        assert made.name == name
        assert make_depth(made) is made
    assert make_depth({"name": "sgbm", "block": 7}).block == 7
    with pytest.raises(ConfigurationError, match=r"no depth estimator named 'sonar'. Known: sgbm"):
        make_depth("sonar")
    with pytest.raises(ConfigurationError, match=r"'sgbm' has no argument 'blocks'.*\"block\""):
        make_depth({"name": "sgbm", "blocks": 7})
    with pytest.raises(ConfigurationError, match=r"multiple of 16"):
        make_depth({"name": "sgbm", "disparities": 100})


def test_frames_without_the_sensor_are_refused() -> None:
    calibration = kitti_rig().calibration
    with pytest.raises(DataError, match=r"no image of camera 2"):
        make_depth("sgbm").disparity(SensorFrame("000000", calibration))
    with pytest.raises(DataError, match=r"no LiDAR scan"):
        make_depth("lidar").disparity(wall(16))
