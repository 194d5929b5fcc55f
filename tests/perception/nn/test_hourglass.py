"""The hourglass in two and three dimensions."""

from __future__ import annotations

import pytest
import torch

from avsec_gym.perception.nn.hourglass import Hourglass


@pytest.mark.parametrize(("dimensions", "size"), [(2, (8, 12)), (3, (8, 12, 20))])
def test_size_in_is_size_out_and_the_waist_is_half(dimensions, size):
    hourglass = Hourglass(4, groups=4, dimensions=dimensions)
    volume = torch.randn(2, 4, *size)
    out, down, up = hourglass(volume)
    half = tuple(side // 2 for side in size)
    assert out.shape == volume.shape
    assert down.shape == up.shape == (2, 8, *half)
    assert down.min() >= 0
    assert up.min() >= 0


def test_an_earlier_hourglass_takes_part():
    torch.manual_seed(0)
    hourglass = Hourglass(4, groups=4, dimensions=2)
    features = torch.randn(1, 4, 8, 8)
    alone, down, up = hourglass(features)
    zeros = torch.zeros_like(up)
    torch.testing.assert_close(hourglass(features, None, zeros)[0], alone)
    assert not torch.allclose(hourglass(features, zeros)[0], alone)
    torch.testing.assert_close(hourglass(features, down)[0], alone)
    assert not torch.allclose(hourglass(features, None, up + 1)[1], down)
