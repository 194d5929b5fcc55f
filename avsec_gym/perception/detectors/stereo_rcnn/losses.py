"""The terms of the training loss and their learned weights (SPEC 5, 6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.detectors.stereo_rcnn.heads import KeypointOutput, PairBoxOutput
from avsec_gym.perception.detectors.stereo_rcnn.stereo_rpn import StereoRpnOutput
from avsec_gym.perception.detectors.stereo_rcnn.targets import PairSamples

TERMS = ("rpn_class", "rpn_box", "class", "box", "dimensions", "keypoints")
"""The terms in the order of the published checkpoints' `uncert`."""

FIT = "fit"
"""The term beside them of a network that predicts how well its boxes fit."""

_RPN_SHARPNESS = 3.0


class TermWeights(nn.Module):
    """Weights by how uncertain each task is (Kendall et al. 2018): ``L exp(-s) + s``.

    Args:
        fit: Whether `FIT` is among the terms.

    Attributes:
        log_variances: s of each of the `TERMS`, shape (6,), learned.
        fit_log_variance: That of `FIT`, shape (1,), by itself, so that the others are the published
            network's; None without it.
    """

    def __init__(self, fit: bool = False) -> None:
        super().__init__()
        self.log_variances = nn.Parameter(torch.full((len(TERMS),), -1.0))
        self.fit_log_variance = nn.Parameter(torch.full((1,), -1.0)) if fit else None

    def learned(self, values: Mapping[str, Sequence[float]]) -> None:
        """Take over what a training learned, as the card of its weights has it, if it has it."""
        for name, value in self.state_dict().items():
            logs = values.get(f"term_weights.{name}")
            if logs is not None:
                value.copy_(torch.tensor(logs))

    def forward(self, terms: dict[str, Tensor]) -> dict[str, Tensor]:
        """The terms as they are added up."""
        logs = dict(zip(TERMS, self.log_variances, strict=True))
        if self.fit_log_variance is not None:
            logs[FIT] = self.fit_log_variance[0]
        return {name: term * torch.exp(-logs[name]) + logs[name] for name, term in terms.items()}


def detection_terms(
    rpn: StereoRpnOutput,
    boxes: PairBoxOutput,
    keypoints: KeypointOutput,
    sampling: PairSamples,
    keypoint_targets: Tensor,
    background_sizes: bool = True,
) -> dict[str, Tensor]:
    """The unweighted terms, by name as in `TERMS`.

    Args:
        rpn: The proposal network's output of B pairs.
        boxes: The boxes for the sampled regions.
        keypoints: The keypoints for the K regions that have keypoints.
        sampling: The sampled regions with their targets.
        keypoint_targets: The keypoint targets of those K regions, shape (B, K, 3).
        background_sizes: Whether the background is drawn towards the mean car, as published.
    """
    terms = (
        *_rpn_terms(rpn, sampling),
        *_region_terms(boxes, sampling, background_sizes),
        _keypoint_term(keypoints, keypoint_targets),
    )
    return dict(zip(TERMS, terms, strict=True))


def smooth_l1(difference: Tensor, sharpness: float = 1.0) -> Tensor:
    """Quadratic up to 1 / sharpness^2, linear beyond, each element."""
    square = sharpness**2
    size = difference.abs()
    return torch.where(size < 1 / square, 0.5 * square * size**2, size - 0.5 / square)


def _rpn_terms(rpn: StereoRpnOutput, sampling: PairSamples) -> tuple[Tensor, Tensor]:
    sampled, true = sampling.anchor_labels >= 0, sampling.anchor_labels == 1
    classes = functional.cross_entropy(rpn.logits[sampled], sampling.anchor_labels[sampled])
    difference = rpn.deltas[true] - sampling.anchor_targets[true]
    # Summed over the anchors, over the sample's size; the mean of the six numbers, as published.
    box = smooth_l1(difference, _RPN_SHARPNESS).sum() / (6 * sampled.sum())
    return classes, box


def _region_terms(
    boxes: PairBoxOutput, sampling: PairSamples, background_sizes: bool
) -> tuple[Tensor, Tensor, Tensor]:
    labels = sampling.labels.flatten()
    rows = torch.arange(len(labels), device=labels.device)
    deltas = boxes.box_deltas.flatten(0, 1)[rows, labels]
    sizes = boxes.dimensions_orientation.flatten(0, 1)[rows, labels]
    classes = functional.cross_entropy(boxes.class_logits.flatten(0, 1), labels)
    difference = (deltas - sampling.box_targets.flatten(0, 1))[labels > 0]
    box = smooth_l1(difference).sum() / len(labels)
    difference = sizes - sampling.dimension_targets.flatten(0, 1)
    if not background_sizes:
        difference = difference[labels > 0]
    dimensions = smooth_l1(difference).sum() / len(labels)
    return classes, box, dimensions


def _keypoint_term(keypoints: KeypointOutput, targets: Tensor) -> Tensor:
    targets = targets.flatten(0, 1)
    borders = keypoints.border_logits.flatten(0, 1)
    logits = (keypoints.corner_logits.flatten(0, 1), borders[:, 0], borders[:, 1])
    columns = [_cells_term(logit, targets[:, i]) for i, logit in enumerate(logits)]
    return torch.stack(columns).mean()


def _cells_term(logits: Tensor, targets: Tensor) -> Tensor:
    """Cross-entropy where there is a target (-1: none); 0 where there is nowhere."""
    total = functional.cross_entropy(logits, targets, ignore_index=-1, reduction="sum")
    return total / (targets >= 0).sum().clamp(min=1)
