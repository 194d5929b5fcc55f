"""PointNet++'s layers by plain loops, and what they do not depend on."""

from __future__ import annotations

import pytest
import torch
from torch import nn

from avsec_gym.perception.nn.point_layers import FeaturePropagation, PointLayer, SetAbstraction
from avsec_gym.perception.nn.point_neighbours import ball_query
from avsec_gym.perception.nn.point_sampling import farthest_points


@pytest.fixture(autouse=True)
def seed() -> None:
    torch.manual_seed(0)


def test_a_layer_is_a_convolution_of_size_one() -> None:
    layer = PointLayer(5, 7).eval()
    features = torch.randn(2, 9, 4, 5)
    normalise = nn.BatchNorm2d(7).eval()
    expected = torch.relu(normalise(layer.conv(features.permute(0, 3, 1, 2))))
    torch.testing.assert_close(layer(features), expected.permute(0, 2, 3, 1))


def test_abstraction_is_the_largest_answer_of_each_ball_at_every_scale() -> None:
    layer = SetAbstraction(4, 6, (0.5, 1.0), (3, 5), ((8,), (8, 9))).eval()
    points, features = torch.rand(1, 50, 3), torch.randn(1, 50, 4)
    with torch.no_grad():
        centres, known = layer(points, features)
        chosen = farthest_points(points, 6)[0]
        assert torch.equal(centres[0], points[0, chosen])
        for number, centre in enumerate(centres[0]):
            parts = []
            for layers, radius, count in zip(layer.mlps, (0.5, 1.0), (3, 5), strict=True):
                ball = ball_query(points, centre[None, None], radius, count)[0, 0]
                answers = [
                    layers(torch.cat([points[0, i] - centre, features[0, i]])[None]) for i in ball
                ]
                parts.append(torch.cat(answers).amax(0))
            torch.testing.assert_close(known[0, number], torch.cat(parts))


def test_moving_all_points_moves_nothing_but_the_centres() -> None:
    layer = SetAbstraction(0, 6, (0.6,), (8,), ((8,),)).eval()
    points = torch.rand(1, 50, 3)
    (centres, known), (moved, same) = layer(points, None), layer(points + 2, None)
    torch.testing.assert_close(moved, centres + 2)
    torch.testing.assert_close(same, known, atol=1e-5, rtol=1e-4)


def test_all_points_become_one_whatever_their_order() -> None:
    layer = SetAbstraction(4, None, (9.0,), (1,), ((8,),)).eval()
    points, features = torch.rand(2, 20, 3), torch.randn(2, 20, 4)
    order = torch.randperm(20)
    place, known = layer(points, features)
    assert place.shape == (2, 1, 3)
    torch.testing.assert_close(layer(points[:, order], features[:, order])[1], known)


def test_propagation_reaches_every_point_and_gradients_come_back() -> None:
    layer = FeaturePropagation([6 + 2, 8])
    points, few = torch.rand(2, 30, 3), torch.rand(2, 5, 3)
    features = torch.randn(2, 30, 2, requires_grad=True)
    few_features = torch.randn(2, 5, 6, requires_grad=True)
    told = layer(points, few, features, few_features)
    assert told.shape == (2, 30, 8)
    told.square().sum().backward()
    for given in (features, few_features):
        assert given.grad is not None
        assert torch.isfinite(given.grad).all()
        assert given.grad.any()
