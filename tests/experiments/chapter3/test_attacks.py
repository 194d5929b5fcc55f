"""What likelihoods are fitted on shares neither kinds nor draws with what is judged."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.attacks.attacks_to_fit_on import FITTED_DISTANCES
from avsec_gym.attacks.facula import THESIS_RADII, Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.attacks import (
    BEYOND,
    OTHER,
    attack_of,
    tampered_frames,
)
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    RIG,
    SYSTEM,
    procedural_drives,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import camera_rig
from avsec_gym.sensor_system import LIDAR


@pytest.fixture(scope="module")
def frame() -> SensorFrame:
    """A tenth as wide and high as KITTI's, which attacks are made in proportion to."""
    rig = camera_rig((0.0, 0.54, -0.27, 0.27), focal_length=72.0, centre=(62, 18), size=(124, 37))
    rng = np.random.default_rng(0)
    images = {c: rng.integers(0, 200, (37, 124, 3), np.uint8) for c in SYSTEM.cameras}
    points = np.c_[rng.uniform(5, 40, (500, 1)), rng.uniform(-5, 5, (500, 3))].astype(np.float32)
    return SensorFrame("0000000000", rig.calibration, images, points)


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


def test_kinds_to_fit_on_are_not_judged() -> None:
    random = np.random.default_rng(0)
    kinds = []
    for sensor in (LIDAR, 3):
        kinds.append({attack_of(sensor, 2, FITTED, random) for _ in range(100)})
        judged = {attack_of(sensor, 2, kind, random) for kind in (JUDGED, *BEYOND)}
        assert not kinds[-1] & judged
        assert all(attack.sensors == {sensor} for attack in kinds[-1] | judged)
    spoofings, faculae = kinds
    assert all(
        spoofing.height != 1.5 for spoofing in spoofings if isinstance(spoofing, LidarSpoofing)
    )
    for facula in faculae:
        assert isinstance(facula, Facula)
        assert facula.colour != (1.0, 1.0, 1.0) or facula.saturation > 0
    # All of them occur.
    assert (len(spoofings), len(faculae)) == (2 * 2 * 2, 2 * (3 + 2))


def test_where_an_attack_is_does_not_depend_on_which_it_is(frame: SensorFrame) -> None:
    places, choices = [], []
    for seed in range(60):
        tampered = tampered_frames(frame, SYSTEM, FITTED, seed)[LIDAR]
        distance, bearing = tampered.settings["distance"], tampered.settings["bearing"]
        low, high = FITTED_DISTANCES[int(distance > 8)]
        places.append((distance - low) / (high - low))
        x, y, z = tampered.frame.points[tampered.points, :3].T
        width = np.ptp(y * np.cos(bearing) - x * np.sin(bearing))
        choices.append([distance > 8, width > 2.5, np.ptp(z) > 1.5])
    # One stream of draws would put each choice into one half of the range of distances: low ones
    # into the near half, so that means would be 0.25 and 0.75.
    for chosen in np.array(choices).T:
        for part in (chosen, ~chosen):
            assert part.sum() > 20
            assert abs(np.mean(places, where=part) - 0.5) < 0.15


def test_lost_rays_are_judged_too(frame: SensorFrame) -> None:
    tampered = tampered_frames(frame, SYSTEM, OTHER, 0)[LIDAR]
    assert tampered.lost is not None
    assert tampered.attacked == {LIDAR}


def test_draws_are_the_frames_own(frame: SensorFrame) -> None:
    one, same, other = (tampered_frames(frame, SYSTEM, JUDGED, (0, n)) for n in (1, 1, 2))
    assert one[2].settings == same[2].settings != other[2].settings
    assert one[2].settings != one[3].settings
    python, numpy = (tampered_frames(frame, SYSTEM, JUDGED, n) for n in (5, np.int64(5)))
    assert python[2].settings == numpy[2].settings


def test_seeds_of_the_parts_never_meet() -> None:
    with pytest.raises(ConfigurationError, match="from 0 to 999"):
        procedural_drives(4, 1000, FITTED)
