"""Stereo R-CNN (Li, Chen and Shen, CVPR 2019): every part can be called by itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.detectors.stereo_rcnn.configuration import StereoRcnnConfiguration
from avsec_gym.perception.detectors.stereo_rcnn.heads import (
    BOX_BINS,
    KEYPOINT_BINS,
    KeypointOutput,
    PairBoxOutput,
    box_trunk,
    keypoint_trunk,
    pool_regions,
)
from avsec_gym.perception.detectors.stereo_rcnn.proposals import PairProposals, propose
from avsec_gym.perception.detectors.stereo_rcnn.stereo_rpn import StereoRpn, StereoRpnOutput
from avsec_gym.perception.nn.feature_pyramid import FeaturePyramid
from avsec_gym.perception.nn.initialisation import normal_weights
from avsec_gym.perception.nn.resnet import EXPANSION, freeze_body, residual_stages, stem


@dataclass(frozen=True, eq=False)
class StereoRcnnOutput:
    """Everything that a forward pass gives; see the parts."""

    rpn: StereoRpnOutput
    proposals: PairProposals
    boxes: PairBoxOutput
    keypoints: KeypointOutput


class StereoRcnnNetwork(nn.Module):
    """`forward` joins what the other methods do: features, proposals, heads.

    Proposals carry no gradient, so whoever gives the heads regions of their own (samples for
    training, frozen proposals for a check of gradients) calls the parts.

    Args:
        configuration: The numbers. Layers have the names of the published checkpoints.
    """

    def __init__(self, configuration: StereoRcnnConfiguration) -> None:
        super().__init__()
        self.configuration = configuration
        channels, classes = configuration.pyramid_channels, configuration.classes
        hidden = configuration.box_channels
        outer = [EXPANSION * inner for inner in configuration.stage_channels]

        self.RCNN_rpn = StereoRpn(configuration)
        self.RCNN_layer0 = stem(configuration)
        (
            self.RCNN_layer1,
            self.RCNN_layer2,
            self.RCNN_layer3,
            self.RCNN_layer4,
        ) = residual_stages(configuration)
        self.RCNN_toplayer = nn.Conv2d(outer[3], channels, 1)
        self.RCNN_smooth1 = nn.Conv2d(channels, channels, 3, padding=1)
        self.RCNN_smooth2 = nn.Conv2d(channels, channels, 3, padding=1)
        self.RCNN_smooth3 = nn.Conv2d(channels, channels, 3, padding=1)
        self.RCNN_latlayer1 = nn.Conv2d(outer[2], channels, 1)
        self.RCNN_latlayer2 = nn.Conv2d(outer[1], channels, 1)
        self.RCNN_latlayer3 = nn.Conv2d(outer[0], channels, 1)
        self.RCNN_top = box_trunk(configuration)
        self.RCNN_kpts = keypoint_trunk(configuration)
        self.RCNN_cls_score = nn.Linear(hidden, classes)
        self.RCNN_bbox_pred = nn.Linear(hidden, 6 * classes)
        self.RCNN_dim_orien_pred = nn.Linear(hidden, 5 * classes)
        self.kpts_class = nn.Conv2d(configuration.keypoint_channels, 6, 1)
        # Not in the published network.
        self.RCNN_fit = nn.Linear(hidden, 1) if configuration.fit else None
        _initialise(self)
        self.train()

    def forward(self, left: Tensor, right: Tensor) -> StereoRcnnOutput:
        """Everything about B pairs of normalised images (B, 3, H, W)."""
        pyramids = self.pair_features(left, right)
        rpn = self.rpn(*pyramids)
        proposals = self.propose(rpn)
        return StereoRcnnOutput(
            rpn, proposals, *self.heads(*pyramids, proposals.left, proposals.right)
        )

    def stages(self, images: Tensor) -> list[Tensor]:
        """C2..C5 of images (B, 3, H, W): strides 4, 8, 16, 32."""
        # Channels last, which pooling, small convolutions and ROI align are faster with.
        features = self.RCNN_layer0(images.contiguous(memory_format=torch.channels_last))
        levels = []
        for stage in (self.RCNN_layer1, self.RCNN_layer2, self.RCNN_layer3, self.RCNN_layer4):
            features = stage(features)
            levels.append(features)
        return levels

    def features(self, images: Tensor) -> FeaturePyramid:
        """P2..P6 of images (B, 3, H, W) of either view."""
        c2, c3, c4, c5 = self.stages(images)
        p5 = self.RCNN_toplayer(c5)
        p4 = self.RCNN_smooth1(merge(p5, self.RCNN_latlayer1(c4)))
        p3 = self.RCNN_smooth2(merge(p4, self.RCNN_latlayer2(c3)))
        p2 = self.RCNN_smooth3(merge(p3, self.RCNN_latlayer3(c2)))
        p6 = functional.max_pool2d(p5, 1, stride=2)
        return FeaturePyramid((p2, p3, p4, p5, p6), images.shape[-2], images.shape[-1])

    def pair_features(self, left: Tensor, right: Tensor) -> tuple[FeaturePyramid, FeaturePyramid]:
        """`features` of both views, in one pass."""
        return self.features(torch.cat((left, right))).halves()

    def rpn(self, left: FeaturePyramid, right: FeaturePyramid) -> StereoRpnOutput:
        """Scores and box deltas of every anchor."""
        output: StereoRpnOutput = self.RCNN_rpn(left, right)
        return output

    def propose(self, output: StereoRpnOutput) -> PairProposals:
        """Pairs of regions, more of them in training; without gradient."""
        configuration = self.configuration
        count = configuration.training_proposals if self.training else configuration.test_proposals
        return propose(
            output,
            count,
            configuration.proposal_overlap,
            exact=configuration.exact_boxes,
            least_side=configuration.least_side,
        )

    def heads(
        self,
        left: FeaturePyramid,
        right: FeaturePyramid,
        left_regions: Tensor,
        right_regions: Tensor,
    ) -> tuple[PairBoxOutput, KeypointOutput]:
        """Both heads, for N regions of each of B pairs, pixels, shape (B, N, 4)."""
        return (
            self.box_head(left, right, left_regions, right_regions),
            self.keypoint_head(left, left_regions),
        )

    def box_head(
        self,
        left: FeaturePyramid,
        right: FeaturePyramid,
        left_regions: Tensor,
        right_regions: Tensor,
    ) -> PairBoxOutput:
        """Class, boxes, size and angle for regions (B, N, 4) of both views."""
        pooled = torch.cat(
            [
                pool_regions(left, left_regions, BOX_BINS, self.configuration),
                pool_regions(right, right_regions, BOX_BINS, self.configuration),
            ],
            1,
        )
        hidden = self.RCNN_top(pooled).mean((2, 3)).unflatten(0, left_regions.shape[:2])
        classes = self.configuration.classes
        return PairBoxOutput(
            self.RCNN_cls_score(hidden),
            self.RCNN_bbox_pred(hidden).unflatten(-1, (classes, 6)),
            self.RCNN_dim_orien_pred(hidden).unflatten(-1, (classes, 5)),
            None if self.RCNN_fit is None else self.RCNN_fit(hidden)[..., 0],
        )

    def keypoint_head(self, left: FeaturePyramid, left_regions: Tensor) -> KeypointOutput:
        """Corners and borders for regions (B, N, 4) of the left view.

        By far the dearest part for each region: in use, call it for the detections alone.
        """
        pooled = pool_regions(left, left_regions, KEYPOINT_BINS, self.configuration)
        maps = self.kpts_class(self.RCNN_kpts(pooled))
        return KeypointOutput(maps.sum(2).unflatten(0, left_regions.shape[:2]))

    def train(self, mode: bool = True) -> Self:
        """`torch.nn.Module.train`, which freezes (again) what the configuration has frozen."""
        super().train(mode)
        body = (
            self.RCNN_layer0,
            self.RCNN_layer1,
            self.RCNN_layer2,
            self.RCNN_layer3,
            self.RCNN_layer4,
        )
        numbers = self.configuration
        freeze_body(self, body, numbers.frozen_stages, numbers.normalisation)
        return self


def _initialise(network: StereoRcnnNetwork) -> None:
    """Normal weights and no biases; the body has its own."""
    he = network.configuration.he_initialisation
    rpn = network.RCNN_rpn
    for name, layer in network.named_children():
        if name.startswith(("RCNN_toplayer", "RCNN_smooth", "RCNN_latlayer")):
            normal_weights(layer, None if he else 0.01)
    normal_weights(rpn.RPN_Conv, None if he else 0.01)
    for layer in (*network.RCNN_top, *network.RCNN_kpts):
        normal_weights(layer, None if he else 0.02)
    normal_weights(rpn.RPN_cls_score, 0.01)
    normal_weights(rpn.RPN_bbox_pred_left_right, 0.01)
    normal_weights(network.RCNN_cls_score, 0.01)
    normal_weights(network.RCNN_bbox_pred, 0.001)
    normal_weights(network.RCNN_dim_orien_pred, 0.001)
    if network.RCNN_fit is not None:
        normal_weights(network.RCNN_fit, 0.01)
    # Its 28 rows are summed up: from scratch, that may not drown every other term.
    normal_weights(network.kpts_class, 0.1 / 28 if he else 0.1)


def merge(upper: Tensor, lateral: Tensor) -> Tensor:
    """A coarser level, enlarged to the size of a finer one, and added to it."""
    size = lateral.shape[-2:]
    return functional.interpolate(upper, size=size, mode="bilinear", align_corners=False) + lateral
