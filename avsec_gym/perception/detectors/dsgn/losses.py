"""What DSGN's anchors cost, term by term (Chen et al., CVPR 2020, section 3.4, and its code)."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.perception.detectors.dsgn.network import DsgnOutput
from avsec_gym.perception.detectors.dsgn.targets import AnchorTargets

_FOCUS = 2.0
_POSITIVE_WEIGHT = 0.25
_TINY = 1e-7
_BEND = 1 / 9
"""Metres: errors of corners count squared below this, linearly above."""


def detection_losses(output: DsgnOutput, targets: AnchorTargets) -> dict[str, Tensor]:
    """The terms `classification`, `box` and `centerness`, and with half turns `reversal`; scalars.

    Args:
        output: The output of the network.
        targets: The targets of the same batch, on any device.
    """
    logits, centerness = at_least_single(output.class_logits), at_least_single(output.centerness)
    targets = targets.to(logits)
    image, angle, _, row, column = targets.index
    positive = torch.zeros_like(logits)
    positive[targets.index] = 1.0
    corners = output.boxes.at(targets.index).to(logits.dtype)
    terms = {
        "classification": focal_loss(logits, positive) / (len(image) + 10),
        "box": box_loss(corners, targets.corners, targets.centerness),
        "centerness": centerness_loss(centerness[image, angle, row, column], targets.centerness),
    }
    if output.reversal is not None:
        terms["reversal"] = reversal_loss(
            at_least_single(output.reversal)[targets.index], targets.reversed, targets.centerness
        )
    return terms


def reversal_loss(logits: Tensor, reverse: Tensor, weight: Tensor) -> Tensor:
    """Binary cross entropy of which way P boxes head, averaged with weights; all of shape (P,)."""
    if len(logits) == 0:
        return logits.sum()
    entropy = functional.binary_cross_entropy_with_logits(logits, reverse, reduction="none")
    return (entropy * weight).sum() / weight.sum()


def focal_loss(logits: Tensor, positive: Tensor) -> Tensor:
    """Sum of the sigmoid focal loss with gamma 2, alpha 1/4 (Lin et al., ICCV 2017).

    Args:
        logits: Any shape.
        positive: 1 where an anchor stands for an object, 0 elsewhere, the same shape.
    """
    p = torch.sigmoid(logits)
    found = _POSITIVE_WEIGHT * (1 - p) ** _FOCUS * torch.log(p + _TINY)
    rejected = (1 - _POSITIVE_WEIGHT) * p**_FOCUS * torch.log(1 - p + _TINY)
    return -(positive * found + (1 - positive) * rejected).sum()


def box_loss(corners: Tensor, true_corners: Tensor, weight: Tensor) -> Tensor:
    """Smooth L1 distance of corners, averaged with weights over P boxes.

    The last of the 24 numbers, z of the last corner, is treated as if it were an angle, as in the
    original, whose loss was written for boxes of 7 parameters: sin(t/2) cos(p/2) stands against
    cos(t/2) sin(p/2).

    Args:
        corners: The corners, shape (P, 8, 3).
        true_corners: The same shape.
        weight: The weight of each, shape (P,), positive.
    """
    if len(corners) == 0:
        return corners.sum()
    predicted, true = corners.flatten(1), true_corners.flatten(1)
    difference = predicted - true
    # sin(t/2) cos(p/2) - cos(t/2) sin(p/2)
    last = torch.sin((true[:, -1:] - predicted[:, -1:]) / 2)
    error = torch.cat([difference[:, :-1], last], dim=1)
    distance = functional.smooth_l1_loss(
        error, torch.zeros_like(error), beta=_BEND, reduction="none"
    )
    return (distance.mean(dim=1) * weight).sum() / weight.sum()


def centerness_loss(logits: Tensor, centerness: Tensor) -> Tensor:
    """Mean binary cross entropy over P positive anchors; both of shape (P,)."""
    if len(logits) == 0:
        return logits.sum()
    return functional.binary_cross_entropy_with_logits(logits, centerness)


def at_least_single(values: Tensor) -> Tensor:
    """Mixed precision delivers halves, which lose the 1e-7 of the focal loss."""
    return values.to(torch.promote_types(values.dtype, torch.float32))
