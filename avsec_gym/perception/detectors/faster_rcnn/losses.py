"""The four terms of the training loss (Ren et al., 2015, equation 1; Girshick, 2015)."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.perception.detectors.faster_rcnn.network import RegionBoxOutput
from avsec_gym.perception.detectors.faster_rcnn.region_proposals import RpnOutput
from avsec_gym.perception.detectors.faster_rcnn.targets import RegionSamples

TERMS = ("rpn_class", "rpn_box", "class", "box")

_RPN_BEND = 1 / 9
"""Where smooth L1 turns from a parabola into a line; 1 in the box head."""


def detection_terms(
    rpn: RpnOutput, boxes: RegionBoxOutput, sampling: RegionSamples
) -> dict[str, Tensor]:
    """The terms by name as in `TERMS`; all have weight 1.

    Args:
        rpn: The proposal network's output of B images.
        boxes: The boxes for the sampled regions.
        sampling: The sampled regions with their targets.
    """
    sampled, true = sampling.anchor_labels >= 0, sampling.anchor_labels == 1
    anchors = sampled.sum().clamp(min=1)
    rpn_class = functional.binary_cross_entropy_with_logits(
        rpn.logits[sampled], sampling.anchor_labels[sampled].to(rpn.logits), reduction="sum"
    )
    rpn_box = _smooth_l1(rpn.deltas[true], sampling.anchor_targets[true], _RPN_BEND)

    labels = sampling.labels.flatten()
    on = labels > 0
    logits, deltas = boxes.class_logits.flatten(0, 1), boxes.deltas.flatten(0, 1)
    rows = torch.arange(len(labels), device=labels.device)
    own = deltas[rows, labels][on]
    box = _smooth_l1(own, sampling.box_targets.flatten(0, 1)[on], 1.0)
    terms = (
        rpn_class / anchors,
        rpn_box / anchors,
        functional.cross_entropy(logits, labels),
        box / len(labels),
    )
    return dict(zip(TERMS, terms, strict=True))


def _smooth_l1(found: Tensor, target: Tensor, bend: float) -> Tensor:
    return functional.smooth_l1_loss(found, target, reduction="sum", beta=bend)
