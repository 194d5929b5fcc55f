"""The heads' inputs and outputs: levels of regions, pooling, the layout of keypoints."""

from __future__ import annotations

import math
from dataclasses import replace

import torch
from torch.nn import functional

from avsec_gym.perception.detectors.stereo_rcnn.configuration import RESNET101, SMALL
from avsec_gym.perception.detectors.stereo_rcnn.heads import (
    KeypointOutput,
    WholeConvolution,
    keypoint_trunk,
    pool_regions,
    roi_levels,
)
from avsec_gym.perception.nn.feature_pyramid import FeaturePyramid


def test_levels_go_by_the_natural_logarithm() -> None:
    """The limits between levels are 224 exp(-1.5), exp(-0.5), exp(0.5) pixels: 50, 136, 369."""
    sides = torch.tensor([1.0, 49.5, 50.5, 135.0, 137.0, 224.0, 368.0, 370.0, 2000.0])
    boxes = torch.stack((sides * 0, sides * 0, 2 * sides - 1, sides / 2 - 1), 1)
    assert roi_levels(boxes, 224.0).tolist() == [2, 2, 3, 3, 4, 4, 4, 5, 5]


def test_regions_are_pooled_from_their_own_level_and_image() -> None:
    """Levels that are constant, each with its own number, show which one was used."""
    shapes = [(48, 80), (24, 40), (12, 20), (6, 10), (3, 5)]
    levels = tuple(
        torch.stack([torch.full((1, *shape), float(level)), torch.full((1, *shape), 10.0 + level)])
        for level, shape in enumerate(shapes, start=2)
    )
    pyramid = FeaturePyramid(levels, 192, 320)
    regions = torch.tensor([[5.0, 5.0, 25.0, 25.0], [10.0, 10.0, 90.0, 90.0], [0, 0, 200, 180]])
    pooled = pool_regions(pyramid, torch.stack((regions, regions.flip(0))), 7, SMALL)
    assert pooled.shape == (6, 1, 7, 7)
    assert pooled.mean((1, 2, 3)).round(decimals=4).tolist() == [2, 3, 4, 14, 13, 12]
    assert pooled.std() > 0
    assert pooled.var((1, 2, 3)).max() < 1e-9


def test_a_convolution_of_the_whole_input_is_one() -> None:
    torch.manual_seed(0)
    layer = WholeConvolution(6, 5, 7)
    inputs = torch.randn(4, 6, 7, 7)
    expected = functional.conv2d(inputs, layer.weight, layer.bias)
    torch.testing.assert_close(layer(inputs), expected, atol=1e-5, rtol=1e-5)


def test_keypoints_have_28_columns_and_six_convolutions_when_published() -> None:
    trunk = keypoint_trunk(replace(RESNET101, pyramid_channels=4, keypoint_channels=8))
    assert trunk(torch.zeros(2, 4, 14, 14)).shape == (2, 8, 28, 28)
    assert sum(isinstance(layer, torch.nn.Conv2d) for layer in trunk) == 6


def test_corners_compete_jointly_and_borders_each_by_itself() -> None:
    logits = torch.zeros(1, 1, 6, 28)
    logits[0, 0, 2, 5] = 20.0
    logits[0, 0, 4, 9] = logits[0, 0, 5, 21] = 20.0
    output = KeypointOutput(logits)
    joint = output.corner_logits.softmax(-1)
    assert joint.shape == (1, 1, 112)
    assert joint.argmax().item() == 2 * 28 + 5
    assert math.isclose(joint.sum().item(), 1, rel_tol=1e-5)
    assert output.border_logits.argmax(-1).flatten().tolist() == [9, 21]
