"""Stereo region proposals: one score for both views, a left and a right box of one height."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.detectors.stereo_rcnn.configuration import StereoRcnnConfiguration
from avsec_gym.perception.nn.anchors import per_anchor, pyramid_anchors
from avsec_gym.perception.nn.feature_pyramid import STRIDES, FeaturePyramid


@dataclass(frozen=True, eq=False)
class StereoRpnOutput:
    """The proposal network's output for B pairs with A anchors each, P2 first, then row by row.

    Args:
        logits: Background and foreground, as the loss takes them, shape (B, A, 2).
        scores: The scores by which proposals are ranked, in [0, 1], shape (B, A).
        deltas: dx, dy, dw, dh of the left box, dx, dw of the right one, shape (B, A, 6).
        anchors: x1, y1, x2, y2, pixels, the same in both views, shape (A, 4).
        height: The height of the images, pixels.
        width: The width of the images, pixels.
    """

    logits: Tensor
    scores: Tensor
    deltas: Tensor
    anchors: Tensor
    height: int
    width: int


class StereoRpn(nn.Module):
    """A 3x3 convolution over each view and level, both views' features joined, two 1x1 maps."""

    def __init__(self, configuration: StereoRcnnConfiguration) -> None:
        super().__init__()
        self.configuration = configuration
        hidden, each = configuration.rpn_channels, len(configuration.anchor_ratios)
        self.RPN_Conv = nn.Conv2d(configuration.pyramid_channels, hidden, 3, padding=1)
        self.RPN_cls_score = nn.Conv2d(2 * hidden, 2 * each, 1)
        self.RPN_bbox_pred_left_right = nn.Conv2d(2 * hidden, 6 * each, 1)

    def forward(self, left: FeaturePyramid, right: FeaturePyramid) -> StereoRpnOutput:
        """Scores and boxes for each anchor."""
        logits, scores, deltas = [], [], []
        for left_level, right_level in zip(left.levels, right.levels, strict=True):
            hidden = torch.cat([self._hidden(left_level), self._hidden(right_level)], 1)
            classes = self.RPN_cls_score(hidden)
            logits.append(per_anchor(classes, 2))
            deltas.append(per_anchor(self.RPN_bbox_pred_left_right(hidden), 6))
            scores.append(self._scores(classes))
        anchors = pyramid_anchors(
            [level.shape[-2:] for level in left.levels],
            STRIDES,
            self.configuration.anchor_sizes,
            self.configuration.anchor_ratios,
        )
        # In the weights' precision, whatever a mixed one computes with: boxes need it.
        anchors = anchors.to(self.RPN_Conv.weight)
        return StereoRpnOutput(
            torch.cat(logits, 1).to(anchors),
            torch.cat(scores, 1).to(anchors),
            torch.cat(deltas, 1).to(anchors),
            anchors,
            left.height,
            left.width,
        )

    def _hidden(self, features: Tensor) -> Tensor:
        return functional.relu(self.RPN_Conv(features))

    def _scores(self, classes: Tensor) -> Tensor:
        """Foreground probability of each anchor, shape (B, A).

        The loss reads a location's channels as pairs (background, foreground). The published
        code ranks proposals by another reading: its softmax is over channel c and c + ratios,
        and of the result it takes each pair's second.
        """
        if not self.configuration.crossed_scores:
            return per_anchor(classes, 2).softmax(-1)[..., 1]
        halves = torch.stack(classes.chunk(2, 1), 1)
        return per_anchor(halves.softmax(1).flatten(1, 2), 2)[..., 1]
