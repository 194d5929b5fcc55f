"""Faster R-CNN (Ren et al., NeurIPS 2015) with a feature pyramid (Lin et al., CVPR 2017)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import torch
from torch import Tensor, nn

from avsec_gym.perception.detectors.faster_rcnn.configuration import FasterRcnnConfiguration
from avsec_gym.perception.detectors.faster_rcnn.region_proposals import (
    RegionProposalNetwork,
    RegionProposals,
    RpnOutput,
    propose,
)
from avsec_gym.perception.nn.feature_pyramid import FeaturePyramid, FeaturePyramidNetwork
from avsec_gym.perception.nn.initialisation import normal_weights
from avsec_gym.perception.nn.region_pooling import COARSEST, FINEST, pooled_regions
from avsec_gym.perception.nn.resnet import EXPANSION, freeze_body, residual_stages, stem

BINS = 7
"""The number of bins along a side of a pooled region."""
_CANONICAL_LEVEL = 4


@dataclass(frozen=True, eq=False)
class RegionBoxOutput:
    """The output of the box head, for N regions of each of B images and K classes (0: background).

    Args:
        class_logits: The class logits, shape (B, N, K).
        deltas: dx, dy, dw, dh against the regions, over their deviations, shape (B, N, K, 4).
    """

    class_logits: Tensor
    deltas: Tensor


class FasterRcnnNetwork(nn.Module):
    """`forward` joins what the other methods do: features, proposals, box head.

    Proposals carry no gradient, so whoever gives the head regions of their own (samples for
    training, frozen proposals for a check of gradients) calls the parts.

    Args:
        configuration: The numbers.
    """

    def __init__(self, configuration: FasterRcnnConfiguration) -> None:
        super().__init__()
        self.configuration = configuration
        channels, hidden = configuration.pyramid_channels, configuration.box_channels
        self.body = nn.ModuleList([stem(configuration), *residual_stages(configuration)])
        self.pyramid = FeaturePyramidNetwork(
            [EXPANSION * inner for inner in configuration.stage_channels], channels
        )
        self.rpn = RegionProposalNetwork(configuration)
        self.box_trunk = nn.Sequential(
            nn.Linear(channels * BINS**2, hidden),
            nn.ReLU(inplace=True),
            nn.Linear(hidden, hidden),
            nn.ReLU(inplace=True),
        )
        self.class_logits = nn.Linear(hidden, configuration.classes)
        self.box_deltas = nn.Linear(hidden, 4 * configuration.classes)
        _initialise(self)
        self.train()

    def forward(self, images: Tensor) -> tuple[RpnOutput, RegionProposals, RegionBoxOutput]:
        """Everything about B normalised images (B, 3, H, W)."""
        pyramid = self.features(images)
        rpn: RpnOutput = self.rpn(pyramid)
        proposals = self.propose(rpn)
        return rpn, proposals, self.box_head(pyramid, proposals.regions)

    def features(self, images: Tensor) -> FeaturePyramid:
        """P2..P6 of images (B, 3, H, W)."""
        # Channels last, which pooling, small convolutions and ROI align are faster with.
        features, levels = images.contiguous(memory_format=torch.channels_last), []
        for part in self.body:
            features = part(features)
            levels.append(features)
        return FeaturePyramid(self.pyramid(levels[1:]), images.shape[-2], images.shape[-1])

    def propose(self, output: RpnOutput) -> RegionProposals:
        """Regions, more of them in training; without gradient."""
        numbers = self.configuration
        count = numbers.training_proposals if self.training else numbers.test_proposals
        return propose(output, count, numbers.proposal_overlap, numbers.least_side)

    def box_head(self, pyramid: FeaturePyramid, regions: Tensor) -> RegionBoxOutput:
        """Class and box for regions (B, N, 4), pixels."""
        numbers = self.configuration
        levels = region_levels(regions.detach().reshape(-1, 4), numbers.canonical_size)
        pooled = pooled_regions(pyramid, regions, levels, BINS, numbers.sampling_ratio)
        hidden = self.box_trunk(pooled.flatten(1)).unflatten(0, regions.shape[:2])
        deltas = self.box_deltas(hidden).unflatten(-1, (numbers.classes, 4))
        return RegionBoxOutput(self.class_logits(hidden), deltas)

    def train(self, mode: bool = True) -> Self:
        """`torch.nn.Module.train`, which freezes (again) what the configuration has frozen."""
        super().train(mode)
        numbers = self.configuration
        freeze_body(self, tuple(self.body), numbers.frozen_stages, numbers.normalisation)
        return self


def region_levels(boxes: Tensor, canonical_size: float) -> Tensor:
    """Level 2..5 of the pyramid that boxes (N, 4) are pooled from (Lin et al., equation 1)."""
    width, height = (boxes[:, 2:] - boxes[:, :2] + 1).clamp(min=1).unbind(1)
    level = _CANONICAL_LEVEL + torch.log2(torch.sqrt(width * height) / canonical_size)
    return level.floor().clamp(FINEST, COARSEST).long()


def _initialise(network: FasterRcnnNetwork) -> None:
    """Normal weights and no biases; the body has its own."""
    small = None if network.configuration.he_initialisation else 0.01
    for layer in (*network.pyramid.modules(), network.rpn.hidden, *network.box_trunk):
        normal_weights(layer, small)
    for layer, deviation in (
        (network.rpn.objectness, 0.01),
        (network.rpn.deltas, 0.01),
        (network.class_logits, 0.01),
        (network.box_deltas, 0.001),
    ):
        normal_weights(layer, deviation)
