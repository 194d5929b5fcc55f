"""PIXOR's training loss, term by term."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration
from avsec_gym.perception.detectors.pixor.network import PixorOutput
from avsec_gym.perception.detectors.pixor.targets import PixorTargets

_POSITIVE_WEIGHT = 0.25
"""The weight of positives in the focal loss (Lin et al., ICCV 2017)."""


def pixor_losses(
    output: PixorOutput, targets: PixorTargets, configuration: PixorConfiguration
) -> dict[str, Tensor]:
    """The terms `classification` and `box`, scalars.

    Args:
        output: The output of the network; cells outside its field of view do not count.
        targets: The targets of the same scans.
        configuration: The configuration of the network; with a `focus`, classification is the focal
            loss over the number of positive cells; without, cross entropy, averaged over all cells.
    """
    logits, values = (_at_least_single(part) for part in (output.logits, output.values))
    judged = targets.judged & output.in_view
    positive = targets.positive & judged
    count = positive.sum().clamp(min=1)
    surprise = functional.binary_cross_entropy_with_logits(
        logits, targets.positive.to(logits), reduction="none"
    )
    if configuration.focus > 0:
        weight = torch.where(positive, _POSITIVE_WEIGHT, 1 - _POSITIVE_WEIGHT)
        missed = 1 - torch.exp(-surprise)
        classification = (weight * missed**configuration.focus * surprise)[judged].sum() / count
    else:
        classification = surprise[judged].sum() / judged.numel()
    distance = functional.smooth_l1_loss(
        values.movedim(1, -1)[positive],
        targets.values.to(values).movedim(1, -1)[positive],
        reduction="sum",
    )
    return {"classification": classification, "box": configuration.box_weight * distance / count}


def _at_least_single(values: Tensor) -> Tensor:
    """Mixed precision delivers halves."""
    return values.to(torch.promote_types(values.dtype, torch.float32))
