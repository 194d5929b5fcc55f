"""What likelihoods are fitted on shares neither sizes nor draws with what is judged."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.attacks.facula import THESIS_RADII
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.attacks import tampered_frames
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    RIG,
    SYSTEM,
    procedural_drives,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR


@pytest.fixture(scope="module")
def frame() -> SensorFrame:
    rng = np.random.default_rng(0)
    images = {c: rng.integers(0, 200, (375, 1242, 3), np.uint8) for c in SYSTEM.cameras}
    points = np.c_[rng.uniform(5, 40, (500, 1)), rng.uniform(-5, 5, (500, 3))].astype(np.float32)
    return SensorFrame("0000000000", RIG.calibration, images, points)


def test_the_rig_sees_depth_between_any_two_cameras() -> None:
    SYSTEM.check(RIG.calibration)
    baselines = [RIG.calibration.baseline(2, 3), RIG.calibration.baseline(3, 1)]
    assert baselines == pytest.approx([0.54, 0.27])


def test_sizes_to_fit_on_lie_outside_those_that_are_judged(frame: SensorFrame) -> None:
    for seed in range(8):
        fitted, judged = (tampered_frames(frame, SYSTEM, part, seed) for part in (FITTED, JUDGED))
        assert set(fitted) == set(judged) == set(SYSTEM.sensors)
        for sensor in SYSTEM.sensors:
            assert fitted[sensor].attacked == judged[sensor].attacked == {sensor}
            size = "distance" if sensor == LIDAR else "radius"
            low, high = (6.0, 10.0) if sensor == LIDAR else THESIS_RADII
            assert low <= judged[sensor].settings[size] <= high
            assert not low < fitted[sensor].settings[size] < high


def test_draws_are_the_moments_own(frame: SensorFrame) -> None:
    one, same, other = (tampered_frames(frame, SYSTEM, JUDGED, (0, n)) for n in (1, 1, 2))
    assert one[2].settings == same[2].settings != other[2].settings
    assert one[2].settings != one[3].settings


def test_seeds_of_the_parts_never_meet() -> None:
    with pytest.raises(ConfigurationError, match="from 0 to 999"):
        procedural_drives(4, 1000, FITTED)
