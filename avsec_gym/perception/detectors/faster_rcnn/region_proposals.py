"""The region proposal network, and its regions (Ren et al., 2015, section 3.1)."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.detectors.faster_rcnn.configuration import FasterRcnnConfiguration
from avsec_gym.perception.nn.anchors import per_anchor, pyramid_anchors
from avsec_gym.perception.nn.box_coding import clip_boxes, decode_boxes, shorter_side
from avsec_gym.perception.nn.feature_pyramid import STRIDES, FeaturePyramid
from avsec_gym.perception.nn.nms import surviving
from avsec_gym.perception.nn.region_counts import ProposalCount


@dataclass(frozen=True, eq=False)
class RpnOutput:
    """The proposal network's output for B images with A anchors each, P2 first, then row by row.

    Args:
        logits: The logits of there being an object, shape (B, A).
        deltas: dx, dy, dw, dh, shape (B, A, 4).
        anchors: x1, y1, x2, y2, pixels, shape (A, 4).
        height: The height of the images, pixels.
        width: The width of the images, pixels.
    """

    logits: Tensor
    deltas: Tensor
    anchors: Tensor
    height: int
    width: int


@dataclass(frozen=True, eq=False)
class RegionProposals:
    """N regions of each of B images, best first, filled up with zeros.

    Args:
        regions: x1, y1, x2, y2, pixels, shape (B, N, 4).
        valid: Whether it is a region or filling, shape (B, N).
    """

    regions: Tensor
    valid: Tensor


class RegionProposalNetwork(nn.Module):
    """A 3x3 convolution and two 1x1 maps over each level."""

    def __init__(self, configuration: FasterRcnnConfiguration) -> None:
        super().__init__()
        self.configuration = configuration
        channels = configuration.pyramid_channels
        each = len(configuration.anchor_ratios) * len(configuration.anchor_scales)
        self.hidden = nn.Conv2d(channels, channels, 3, padding=1)
        self.objectness = nn.Conv2d(channels, each, 1)
        self.deltas = nn.Conv2d(channels, 4 * each, 1)

    def forward(self, pyramid: FeaturePyramid) -> RpnOutput:
        """An objectness and a box for each anchor."""
        hidden = [functional.relu(self.hidden(level)) for level in pyramid.levels]
        anchors = pyramid_anchors(
            [level.shape[-2:] for level in pyramid.levels],
            STRIDES,
            self.configuration.anchor_sizes,
            self.configuration.anchor_ratios,
            self.configuration.anchor_scales,
        )
        # In the weights' precision, whatever a mixed one computes with: boxes need it.
        anchors = anchors.to(self.hidden.weight)
        logits = torch.cat([per_anchor(self.objectness(level), 1) for level in hidden], 1)
        deltas = torch.cat([per_anchor(self.deltas(level), 4) for level in hidden], 1)
        return RpnOutput(
            logits[..., 0].to(anchors), deltas.to(anchors), anchors, pyramid.height, pyramid.width
        )


@torch.no_grad()
def propose(
    output: RpnOutput, count: ProposalCount, overlap: float, least_side: float = 0.0
) -> RegionProposals:
    """The best regions that survive suppression; no gradient passes.

    Args:
        output: The output of the proposal network.
        count: Regions before and after suppression.
        overlap: The overlap above which a worse region is suppressed.
        least_side: Lower or narrower regions are dropped, pixels.
    """
    images = len(output.logits)
    regions = output.deltas.new_zeros(images, count.after, 4)
    valid = torch.zeros_like(regions[..., 0], dtype=torch.bool)
    for image in range(images):
        order = torch.argsort(output.logits[image], descending=True, stable=True)[: count.before]
        boxes = decode_boxes(output.anchors[order], output.deltas[image, order])
        boxes = clip_boxes(boxes, output.height, output.width)
        boxes = boxes[shorter_side(boxes) >= least_side]
        kept = boxes[surviving(boxes, overlap)][: count.after]
        regions[image, : len(kept)] = kept
        valid[image, : len(kept)] = True
    return RegionProposals(regions, valid)
