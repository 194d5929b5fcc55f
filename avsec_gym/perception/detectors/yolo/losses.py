"""The four terms of the training loss (Redmon and Farhadi, 2018, section 2.1).

Squares of the errors of sizes, and logistic regression for the rest: of the centre, too, since the
paper's gradient of t_x, truth less prediction, is that of the cross-entropy.
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.perception.detectors.yolo.network import YoloOutput
from avsec_gym.perception.detectors.yolo.targets import YoloTargets

TERMS = ("centre", "size", "objectness", "class")


def detection_terms(output: YoloOutput, targets: YoloTargets) -> dict[str, Tensor]:
    """The terms by name as in `TERMS`: sums over boxes, means over images; all have weight 1."""
    standing = (targets.image, targets.box)
    logits, weights = output.logits[standing], targets.weights[:, None]
    is_object = torch.zeros_like(output.objectness)
    is_object[standing] = 1
    classes = output.classes[standing]
    is_class = functional.one_hot(targets.classes, classes.shape[-1]).to(classes)
    terms = (
        (weights * _cross_entropy(logits[:, :2], targets.offsets)).sum(),
        (weights * (logits[:, 2:4] - targets.sizes).square() / 2).sum(),
        _cross_entropy(output.objectness, is_object)[targets.judged].sum(),
        _cross_entropy(classes, is_class).sum(),
    )
    return {name: term / len(output.logits) for name, term in zip(TERMS, terms, strict=True)}


def _cross_entropy(logits: Tensor, truth: Tensor) -> Tensor:
    return functional.binary_cross_entropy_with_logits(logits, truth, reduction="none")
