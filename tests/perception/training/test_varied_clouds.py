"""A varied scan is still true: its cars stand where its points are."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.perception.detectors.pixor.targets import owners
from avsec_gym.perception.training.cloud_samples import CloudSample
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.pixor_task import PixorTask
from avsec_gym.perception.training.scan_variation import varied

LARGEST_TURN = PixorTask.largest_turn


@pytest.fixture
def sample() -> CloudSample:
    points = np.random.default_rng(0).uniform([0, -20, -2, 0], [40, 20, 1, 1], (4000, 4))
    cars = np.array([[12.0, 5.0, 8.0, 3.0, 0.7], [25.0, -9.0, 7.0, 4.0, -2.0]])
    vans = np.array([[30.0, 8.0, 9.0, 5.0, 1.2]])
    return CloudSample(points.astype(np.float32), cars, vans, (-0.7, 0.6))


def test_points_stay_on_their_objects_and_in_view(sample: CloudSample) -> None:
    randomness = np.random.default_rng(1)
    owner = owners(sample.points[:, :2], np.concatenate([sample.rectangles, sample.ignored]))
    assert all((owner == number).sum() > 30 for number in range(3))
    for _ in range(10):
        other = varied(sample, Augmentation(zoom=1.3), LARGEST_TURN, randomness)
        rectangles = np.concatenate([other.rectangles, other.ignored])
        assert (owners(other.points[:, :2], rectangles) == owner).mean() > 0.999
        assert (_in_view(other) == _in_view(sample)).mean() > 0.999
        np.testing.assert_array_equal(other.points[:, 3], sample.points[:, 3])


def _in_view(sample: CloudSample) -> np.ndarray:
    direction = np.arctan2(sample.points[:, 1], sample.points[:, 0])
    return (direction > sample.azimuths[0]) & (direction < sample.azimuths[1])


def test_each_variation_is_what_it_says(sample: CloudSample) -> None:
    car = sample.rectangles[0]
    assert sample.mirrored().rectangles[0] == pytest.approx([12, -5, 8, 3, -0.7])
    assert sample.mirrored().azimuths == (-0.6, 0.7)
    quarter = sample.turned(np.pi / 2)
    assert quarter.rectangles[0] == pytest.approx([-5, 12, 8, 3, 0.7 + np.pi / 2])
    assert quarter.points[0, :2] == pytest.approx(sample.points[0, [1, 0]] * [-1, 1], abs=1e-5)
    larger = sample.scaled(1.1)
    assert larger.rectangles[0] == pytest.approx([*(1.1 * car[:4]), 0.7])
    np.testing.assert_allclose(larger.points[:, :3], 1.1 * sample.points[:, :3], rtol=1e-5)


def test_how_far_it_goes(sample: CloudSample) -> None:
    randomness = np.random.default_rng(2)
    car = sample.rectangles[0]
    turns, scales, flips = [], [], 0
    for _ in range(200):
        other = varied(sample, Augmentation(flip=0.5, zoom=1.1), LARGEST_TURN, randomness)
        right, left = other.azimuths
        is_flipped = left - right > 0 and other.rectangles[0, 4] < 0.2
        flips += is_flipped
        turns.append(right + (0.6 if is_flipped else 0.7))
        scales.append(other.rectangles[0, 2] / car[2])
    assert 70 < flips < 130
    assert max(np.abs(turns)) == pytest.approx(LARGEST_TURN, rel=0.05)
    assert max(np.abs(turns)) <= LARGEST_TURN + 1e-9
    assert (min(scales), max(scales)) == pytest.approx((1.1**-0.5, 1.1**0.5), rel=0.01)
    same = varied(sample, Augmentation(zoom=1.0, flip=0.0), LARGEST_TURN, randomness)
    assert same.rectangles[0, 2:4].tolist() == car[2:4].tolist()
