"""The layers below all others."""

from __future__ import annotations

import pytest
import torch
from torch import nn
from torch.nn import functional

from avsec_gym.perception.nn.convolution import (
    DoublingVolumeConvolution,
    VolumeConvolution,
    convolutions,
    initialise,
    normalisation,
)


@pytest.mark.parametrize("shape", [(4, 6, 10), (5, 1, 3), (1, 2, 2)])
def test_one_volume_is_doubled_as_two_are(shape):
    torch.manual_seed(0)
    layer = DoublingVolumeConvolution(4, 6).double()
    volume = torch.randn(1, 4, *shape, dtype=torch.float64, requires_grad=True)
    expected = functional.conv_transpose3d(
        volume, layer.weight, None, stride=2, padding=1, output_padding=1
    )
    torch.testing.assert_close(layer(volume), expected)
    torch.testing.assert_close(layer(volume.expand(2, -1, -1, -1, -1))[1:], expected)
    towards = torch.randn_like(expected)
    ours = torch.autograd.grad(layer(volume), (volume, layer.weight), towards)
    theirs = torch.autograd.grad(expected, (volume, layer.weight), towards)
    torch.testing.assert_close(ours, theirs)


@pytest.mark.parametrize(("kernel", "stride"), [(3, 1), (3, 2), (1, 1)])
@pytest.mark.parametrize("shape", [(8, 12, 20), (5, 7, 9)])
def test_one_volume_is_convolved_as_two_are(kernel, stride, shape):
    torch.manual_seed(0)
    layer = VolumeConvolution(4, 6, kernel, stride=stride, padding=kernel // 2).double()
    volume = torch.randn(1, 4, *shape, dtype=torch.float64, requires_grad=True)
    expected = functional.conv3d(volume, layer.weight, layer.bias, stride, kernel // 2)
    torch.testing.assert_close(layer(volume), expected)
    towards = torch.randn_like(expected)
    ours = torch.autograd.grad(layer(volume), (volume, layer.weight), towards)
    theirs = torch.autograd.grad(expected, (volume, layer.weight), towards)
    torch.testing.assert_close(ours, theirs)


def test_few_channels_are_normalised_over_the_batch():
    assert isinstance(normalisation(16, 32, 2), nn.BatchNorm2d)
    assert isinstance(normalisation(32, 32, 3), nn.GroupNorm)
    assert isinstance(normalisation(64, 0, 3), nn.BatchNorm3d)


def test_a_row_shrinks_once_and_is_nowhere_negative():
    row = convolutions(3, 8, 16, groups=4, stride=2)
    out = row(torch.randn(2, 3, 16, 24))
    assert out.shape == (2, 16, 8, 12)
    assert out.min() == 0
    assert [key for key, _ in row.named_parameters() if "weight" in key] == [
        "0.0.weight",
        "0.1.weight",
        "2.0.weight",
        "2.1.weight",
    ]


def test_activations_keep_their_scale_through_many_layers():
    torch.manual_seed(0)
    deep = nn.Sequential(
        *(layer for _ in range(20) for layer in (nn.Conv2d(32, 32, 3, padding=1), nn.ReLU()))
    )
    initialise(deep)
    ratio = deep(torch.randn(1, 32, 32, 32)).std()
    assert 0.1 < ratio < 10
