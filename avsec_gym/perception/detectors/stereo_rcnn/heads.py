"""What Stereo R-CNN predicts of each region: class, both boxes, size, angle, keypoints."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.detectors.stereo_rcnn.configuration import StereoRcnnConfiguration
from avsec_gym.perception.nn.feature_pyramid import FeaturePyramid
from avsec_gym.perception.nn.region_pooling import pooled_regions

BOX_BINS, KEYPOINT_BINS = 7, 14
"""Bins along one side of a region, for the box head and the keypoint head."""


@dataclass(frozen=True, eq=False)
class PairBoxOutput:
    """The output of the box head, for N regions of each of B images and K classes (0: background).

    Args:
        class_logits: The class logits, shape (B, N, K).
        box_deltas: dx, dy, dw, dh of the left box and dx, dw of the right one, against the
            regions, in units of the standard deviations (0.1, 0.1, 0.2, 0.2, 0.1, 0.2),
            shape (B, N, K, 6).
        dimensions_orientation: Width, height, length less (1.6, 1.5, 4.0) m, sin and cos of the
            viewpoint angle, all over 0.5, shape (B, N, K, 5).
        fit_logits: How well the box fits, if the network predicts it, shape (B, N).
    """

    class_logits: Tensor
    box_deltas: Tensor
    dimensions_orientation: Tensor
    fit_logits: Tensor | None = None

    @property
    def class_probabilities(self) -> Tensor:
        """Shape (B, N, K)."""
        return self.class_logits.softmax(-1)


@dataclass(frozen=True, eq=False)
class KeypointOutput:
    """The keypoint head's output: logits over the 28 columns of a region of the left image.

    Args:
        logits: Four bottom corners, the left and the right visible border, shape (B, N, 6, 28).
    """

    logits: Tensor

    @property
    def corner_logits(self) -> Tensor:
        """Which corner and where, jointly: index = corner * 28 + column, shape (B, N, 112)."""
        return self.logits[:, :, :4].flatten(2)

    @property
    def border_logits(self) -> Tensor:
        """Column of the left and of the right border, shape (B, N, 2, 28)."""
        return self.logits[:, :, 4:]


def pool_regions(
    pyramid: FeaturePyramid, regions: Tensor, bins: int, configuration: StereoRcnnConfiguration
) -> Tensor:
    """ROI align of every region on its own level of P2..P5.

    Args:
        pyramid: The pyramid of B images of one view.
        regions: x1, y1, x2, y2, pixels of the network's input, shape (B, N, 4).
        bins: The number of bins along a side.
        configuration: The configuration, with the canonical size and the sampling ratio.

    Returns:
        Features, shape (B * N, C, bins, bins).
    """
    levels = roi_levels(regions.detach().reshape(-1, 4), configuration.canonical_size)
    return pooled_regions(pyramid, regions, levels, bins, configuration.sampling_ratio)


def roi_levels(boxes: Tensor, canonical_size: float) -> Tensor:
    """Level 2..5 of the pyramid that boxes (N, 4) are pooled from.

    The logarithm is the natural one, as in the published code (feature pyramid networks take
    the binary one), so a level spans a factor of e.
    """
    width, height = (boxes[:, 2:] - boxes[:, :2] + 1).clamp(min=1).unbind(1)
    level = 4 + torch.log(torch.sqrt(width * height) / canonical_size)
    return level.round().clamp(2, 5).long()


def box_trunk(configuration: StereoRcnnConfiguration) -> nn.Sequential:
    """Two hidden layers over the 7x7 bins of both views."""
    channels, dropout = configuration.box_channels, configuration.box_dropout
    return nn.Sequential(
        WholeConvolution(2 * configuration.pyramid_channels, channels, BOX_BINS),
        nn.ReLU(inplace=True),
        nn.Dropout(dropout),
        nn.Conv2d(channels, channels, 1),
        nn.ReLU(inplace=True),
        nn.Dropout(dropout),
    )


class WholeConvolution(nn.Conv2d):
    """A convolution as large as its input: as a matrix product, ten times faster on a CPU."""

    def forward(self, inputs: Tensor) -> Tensor:
        """(N, C, kernel, kernel) to (N, out_channels, 1, 1)."""
        product = functional.linear(inputs.flatten(1), self.weight.flatten(1), self.bias)
        return product[:, :, None, None]


def keypoint_trunk(configuration: StereoRcnnConfiguration) -> nn.Sequential:
    """3x3 convolutions over 14x14 bins of the left view, then 28x28."""
    channels = configuration.keypoint_channels
    layers: list[nn.Module] = []
    inputs = configuration.pyramid_channels
    for _ in range(configuration.keypoint_convolutions):
        layers += [nn.Conv2d(inputs, channels, 3, padding=1), nn.ReLU(inplace=True)]
        inputs = channels
    layers += [nn.ConvTranspose2d(inputs, channels, 2, stride=2), nn.ReLU(inplace=True)]
    return nn.Sequential(*layers)
