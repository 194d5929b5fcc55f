"""Feature pyramids against the sums that the paper draws."""

from __future__ import annotations

import torch
from torch.nn import functional

from avsec_gym.perception.nn.feature_pyramid import FeaturePyramid, FeaturePyramidNetwork


def test_every_level_gets_all_coarser_ones() -> None:
    torch.manual_seed(0)
    network = FeaturePyramidNetwork((3, 4, 5, 6), 2)
    sizes = ((16, 24), (8, 12), (4, 6), (2, 3))
    levels = [torch.randn(1, 3 + i, *size) for i, size in enumerate(sizes)]
    found = network(levels)
    above = torch.zeros(1, 2, 1, 1)
    for i in (3, 2, 1, 0):
        enlarged = above if i == 3 else above.repeat_interleave(2, -1).repeat_interleave(2, -2)
        above = network.lateral[i](levels[i]) + enlarged
        expected = functional.conv2d(
            above, network.smooth[i].weight, network.smooth[i].bias, padding=1
        )
        torch.testing.assert_close(found[i], expected)
    torch.testing.assert_close(found[4], found[3][..., ::2, ::2])


def test_halves_are_the_two_views() -> None:
    levels = (torch.arange(4.0)[:, None, None, None], torch.arange(4.0)[:, None, None, None] * 2)
    first, second = FeaturePyramid(levels, 1, 1).halves()
    assert first.levels[1].flatten().tolist() == [0, 2]
    assert second.levels[0].flatten().tolist() == [2, 3]
