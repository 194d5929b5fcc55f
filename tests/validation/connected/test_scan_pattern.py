"""The pattern of a LiDAR's beams, read off scans with beams that are known."""

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.scan_pattern import ScanPattern, scan_pattern
from avsec_gym.validation.connected.sweep import TIP


def _scan(beams: int, low: float, high: float) -> np.ndarray:
    """All beams of a sensor in a round hall of 30 m, on flat ground."""
    up, around = np.meshgrid(
        np.radians(np.linspace(low, high, beams)), np.radians(np.arange(0, 360, 0.2))
    )
    up, around = up.ravel(), around.ravel()
    flat = np.minimum(30.0, np.where(up < 0, (1.73 + TIP) / np.tan(-np.minimum(up, -1e-9)), 30.0))
    x, y, z = flat * np.cos(around), flat * np.sin(around), flat * np.tan(up) + TIP
    return np.stack([x, y, z, 0 * x], axis=1).astype(np.float32)


@pytest.mark.parametrize(
    ("beams", "low", "high"), [(64, -24.8, 2.0), (32, -30.7, 10.7), (128, -25.0, 15.0)]
)
def test_the_spacing_is_that_of_the_sensor(beams: int, low: float, high: float) -> None:
    pattern = scan_pattern(_scan(beams, low, high))
    assert pattern is not None
    assert pattern.spacing == pytest.approx((high - low) / (beams - 1), rel=0.05)
    assert pattern.lowest == pytest.approx(low, abs=0.5)


def test_a_third_of_the_returns_may_be_missing_and_stray_ones_are_no_beam() -> None:
    scan, random = _scan(64, -24.8, 2.0), np.random.default_rng(0)
    some = scan[random.random(len(scan)) > 0.3]
    stray = random.uniform(-30, 30, (50, 4)).astype(np.float32)
    whole, torn = scan_pattern(scan), scan_pattern(np.concatenate([some, stray]))
    assert whole is not None
    assert torn is not None
    whole.check(torn)


def test_another_sensor_is_refused_and_named() -> None:
    of_64, of_32 = scan_pattern(_scan(64, -24.8, 2.0)), scan_pattern(_scan(32, -30.7, 10.7))
    assert of_64 is not None
    assert of_32 is not None
    with pytest.raises(ConfigurationError, match=r"1\.3. degrees apart"):
        of_64.check(of_32)
    with pytest.raises(ConfigurationError):
        of_32.check(of_64)


def test_what_is_no_scan_has_no_pattern() -> None:
    assert scan_pattern(np.zeros((0, 4), np.float32)) is None
    assert scan_pattern(np.full((100, 4), np.nan, np.float32)) is None
    with pytest.raises(ConfigurationError):
        ScanPattern(0.0, -20.0)
