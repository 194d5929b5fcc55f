"""Noise of the size that was asked for, the same for the same seed."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.attacks.attack import Attack, Victim
from avsec_gym.attacks.noise import RandomNoise
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.perception.detectors.recorded import Oracle

VICTIM = Victim(Oracle(), Boxes3D.empty())


def frame_of(level: int, cameras: tuple[int, ...] = (2, 3)) -> SensorFrame:
    projection = np.array([[700.0, 0, 20, 0], [0, 700, 15, 0], [0, 0, 1, 0]])
    right = projection - [[0, 0, 0, 350.0], [0] * 4, [0] * 4]
    calibration = Calibration([projection] * 3 + [right], np.eye(3), np.eye(4)[:3])
    image = np.full((30, 40, 3), level, np.uint8)
    return SensorFrame("0", calibration, dict.fromkeys(cameras, image))


def changes(noise: RandomNoise, seed: int = 0, level: int = 128) -> np.ndarray:
    frame = frame_of(level)
    attacked = noise.attack(frame, VICTIM, seed)
    assert not noise.budget.exceeded_by(frame, attacked)
    return np.stack([attacked.image(2), attacked.image(3)]) - np.float32(level)


def test_every_pixel_goes_all_the_way_up_or_down() -> None:
    assert isinstance(RandomNoise(), Attack)
    change = changes(RandomNoise(4.0))
    assert set(np.unique(change)) == {-4.0, 4.0}
    # 7200 tosses of a coin; the two views are tossed apart.
    assert abs(change.mean()) < 4 * 4 / np.sqrt(change.size)
    assert 0.4 < (change[0] == change[1]).mean() < 0.6


def test_uniform_noise_fills_the_range() -> None:
    change = changes(RandomNoise(0.4, uniform=True))
    assert change.min() < -0.39
    assert change.max() > 0.39
    assert change.std() == pytest.approx(0.4 / np.sqrt(3), rel=0.05)


def test_the_seed_decides() -> None:
    np.testing.assert_array_equal(changes(RandomNoise(), 1), changes(RandomNoise(), 1))
    assert (changes(RandomNoise(), 1) != changes(RandomNoise(), 2)).any()


def test_images_stay_images() -> None:
    assert changes(RandomNoise(10.0), level=252).max() == 3
    assert changes(RandomNoise(10.0), level=2).min() == -2


def test_bad_settings_and_frames_are_refused() -> None:
    for strength in (0.0, -1.0, 256.0, float("nan")):
        with pytest.raises(ConfigurationError, match="strength"):
            RandomNoise(strength)
    with pytest.raises(DataError, match="camera 3"):
        RandomNoise().attack(frame_of(9, cameras=(2,)), VICTIM)
