"""A varied scan is still true: its cars stand where its points are."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from avsec_gym.perception.nn.points_in_boxes import points_in_boxes
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.point_samples import PointSample
from avsec_gym.perception.training.pointrcnn_task import PointRcnnTask
from avsec_gym.perception.training.scan_variation import varied

LARGEST_TURN = PointRcnnTask.largest_turn


@pytest.fixture
def sample() -> PointSample:
    points = np.random.default_rng(0).uniform([-20, 0, 0], [20, 2, 40], (4000, 3))
    cars = np.array([[5.0, 1.9, 12, 1.5, 3, 8, 0.7], [-9, 1.8, 25, 1.7, 4, 7, -2]])
    hidden = np.array([[5.0, 1.9, 30, 1.5, 3, 8, 1.1]])
    return PointSample(points.astype(np.float32), cars, hidden)


def owners(sample: PointSample) -> np.ndarray:
    boxes = torch.from_numpy(np.concatenate([sample.objects, sample.ignored]))
    return points_in_boxes(torch.from_numpy(sample.points).double(), boxes).numpy()


def test_points_stay_on_their_objects(sample: PointSample) -> None:
    randomness = np.random.default_rng(1)
    before = owners(sample)
    assert (before.sum(axis=1) > 20).all()
    for _ in range(10):
        other = varied(sample, Augmentation(zoom=1.3), LARGEST_TURN, randomness)
        assert (owners(other) == before).mean() > 0.999
        assert not np.array_equal(other.points, sample.points)


def test_each_variation_is_what_it_says(sample: PointSample) -> None:
    car = sample.objects[0]
    other = sample.mirrored().objects[0]
    assert other[:6] == pytest.approx([-5, *car[1:6]])
    # Seen in the mirror, what is ahead stays ahead, and what is right becomes left.
    assert np.cos(other[6]) == pytest.approx(-np.cos(car[6]))
    assert np.sin(other[6]) == pytest.approx(np.sin(car[6]))
    quarter = sample.turned(np.pi / 2)
    assert quarter.objects[0] == pytest.approx([12, 1.9, -5, *car[3:6], 0.7 + np.pi / 2])
    np.testing.assert_allclose(quarter.points, sample.points[:, [2, 1, 0]] * [1, 1, -1], atol=1e-5)
    larger = sample.scaled(1.1)
    assert larger.objects[0] == pytest.approx([*(1.1 * car[:6]), 0.7])


def test_how_far_it_goes(sample: PointSample) -> None:
    randomness = np.random.default_rng(2)
    turns, scales = [], []
    for _ in range(200):
        other = varied(sample, Augmentation(flip=0.0, zoom=1.1), LARGEST_TURN, randomness)
        turns.append(other.objects[0, 6] - 0.7)
        scales.append(other.objects[0, 5] / 8)
    assert np.abs(turns).max() == pytest.approx(LARGEST_TURN, rel=0.05)
    assert np.abs(turns).max() <= LARGEST_TURN + 1e-9
    assert (min(scales), max(scales)) == pytest.approx((1.1**-0.5, 1.1**0.5), rel=0.01)
    flipped = [
        varied(sample, Augmentation(flip=0.5), LARGEST_TURN, randomness).objects[0, 0] < 0
        for _ in range(200)
    ]
    assert 70 < sum(flipped) < 130
