"""Plane-sweep volumes against plain loops, and a scene whose disparity is known."""

from __future__ import annotations

import math

import pytest
import torch
from torch.nn import functional

from avsec_gym.perception.nn.cost_volume import (
    disparity_volume,
    enlarged,
    expectation,
    sampled_volume,
)


def _features(*shape):
    return torch.randn(*shape, dtype=torch.float64, generator=torch.Generator().manual_seed(0))


def _sampled(row, place):
    """Linear between neighbours, 0 outside."""
    if place < 0 or place > len(row) - 1:
        return 0.0
    below = math.floor(place)
    above = min(below + 1, len(row) - 1)
    return float(row[below] + (place - below) * (row[above] - row[below]))


def test_whole_disparities_leave_both_halves_empty_at_the_edge():
    left, right = _features(2, 2, 3, 3, 6)
    volume = disparity_volume(left, right, 8)
    expected = torch.zeros(2, 6, 8, 3, 6, dtype=torch.float64)
    for d in range(8):
        for x in range(d, 6):
            expected[:, :3, d, :, x] = left[..., x]
            expected[:, 3:, d, :, x] = right[..., x - d]
    torch.testing.assert_close(volume, expected)


def test_planes_may_lie_anywhere_and_differ_between_pairs():
    left, right = _features(2, 2, 3, 2, 7)
    disparities = torch.tensor([[0.0, 0.25, 2.0, 3.9, 9.0], [5.5, 6.0, 6.5, 1.0, 0.5]])
    volume = sampled_volume(left, right, disparities)
    for b, plane, c, y, x in torch.cartesian_prod(*map(torch.arange, (2, 5, 3, 2, 7))).tolist():
        assert volume[b, c, plane, y, x] == left[b, c, y, x]
        place = x - disparities[b, plane].item()
        found = volume[b, 3 + c, plane, y, x].item()
        assert math.isclose(found, _sampled(right[b, c, y], place), abs_tol=1e-6)


def test_gradient_flows_to_both_images():
    left, right = _features(2, 1, 2, 2, 5)
    disparities = torch.tensor([[0.0, 1.3, 4.2]])
    inputs = (left.requires_grad_(), right.requires_grad_())
    assert torch.autograd.gradcheck(lambda a, b: sampled_volume(a, b, disparities), inputs)
    assert torch.autograd.gradcheck(lambda a, b: disparity_volume(a, b, 3), inputs)


@pytest.mark.parametrize("aligned", [True, False])
def test_costs_are_enlarged_in_all_three_dimensions(aligned):
    costs = _features(2, 2, 4, 3, 5)[0]
    expected = functional.interpolate(
        costs[:, None], size=(16, 12, 20), mode="trilinear", align_corners=aligned
    )[:, 0]
    torch.testing.assert_close(enlarged(costs, (16, 12, 20), aligned), expected)


def test_expectation_of_a_sure_and_of_an_undecided_pixel():
    logits = torch.tensor([[0.0, 0.0], [0.0, 50.0], [0.0, 0.0]])[None, :, None]
    found = expectation(logits, torch.tensor([1.0, 2.0, 6.0]))
    torch.testing.assert_close(found, torch.tensor([[[3.0, 2.0]]]))
