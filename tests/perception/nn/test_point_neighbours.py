"""Neighbours by scipy's trees and by plain loops."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy.spatial import cKDTree
from torch import Tensor

from avsec_gym.perception.nn.point_neighbours import (
    ball_query,
    gathered,
    interpolated,
    three_nearest,
)


@pytest.fixture
def clouds() -> Tensor:
    return torch.rand(2, 300, 3, generator=torch.Generator().manual_seed(0)) * 4


def test_balls_hold_the_first_points_within_reach(clouds: Tensor) -> None:
    centres = torch.cat([clouds[:, :20], torch.full((2, 1, 3), 99.0)], 1)
    found = ball_query(clouds, centres, 0.9, 8)
    assert found.shape == (2, 21, 8)
    few = 0
    for cloud, middles, rows in zip(clouds.double(), centres.double(), found, strict=True):
        tree = cKDTree(cloud.numpy())
        for middle, row in zip(middles[:-1].numpy(), rows[:-1].tolist(), strict=True):
            near = sorted(tree.query_ball_point(middle, 0.9))[:8]
            assert row == near + near[:1] * (8 - len(near))
            few += len(near) < 8
        assert rows[-1].tolist() == [0] * 8
    assert 0 < few < 40


def test_the_border_of_a_ball_is_outside() -> None:
    points = torch.tensor([[[2.0, 0, 0], [1, 0, 0], [0.5, 0, 0]]])
    assert ball_query(points, torch.zeros(1, 1, 3), 1.0, 2).tolist() == [[[2, 2]]]


def test_three_nearest_as_by_a_tree(clouds: Tensor) -> None:
    known = clouds[:, :40] + 0.05
    distances, index = three_nearest(clouds, known)
    for cloud, few, length, which in zip(clouds, known, distances, index, strict=True):
        far, place = cKDTree(few.double().numpy()).query(cloud.double().numpy(), 3)
        np.testing.assert_array_equal(which, place)
        np.testing.assert_allclose(length, far, atol=1e-5)


def test_interpolation_is_exact_at_known_points_and_weighs_by_nearness() -> None:
    known = torch.tensor([[[0.0, 0, 0], [3, 0, 0], [0, 9, 0], [50, 0, 0]]])
    said = torch.tensor([[[1.0, 10], [2, 20], [3, 30], [99, 99]]])
    places = torch.tensor([[[0.0, 0, 0], [1, 0, 0]]])
    told = interpolated(said, *three_nearest(places, known))
    assert told[0, 0].tolist() == pytest.approx([1, 10])
    weights = np.array([1, 1 / 2, 1 / np.sqrt(82)])
    assert told[0, 1, 0].item() == pytest.approx(weights @ [1, 2, 3] / weights.sum())


def test_gathering_takes_rows_and_gives_gradients_back() -> None:
    features = torch.randn(2, 6, 4, dtype=torch.float64, requires_grad=True)
    index = torch.tensor([[[0, 5], [5, 5]], [[1, 2], [3, 1]]])
    taken = gathered(features, index)
    for cloud in range(2):
        for i in range(2):
            for j in range(2):
                assert torch.equal(taken[cloud, i, j], features[cloud, index[cloud, i, j]])
    taken.sum().backward()
    assert features.grad is not None
    assert features.grad[..., 0].tolist() == [[1, 0, 0, 0, 0, 3], [0, 2, 1, 1, 0, 0]]
