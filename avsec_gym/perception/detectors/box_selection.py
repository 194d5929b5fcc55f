"""Which of the boxes that a network gives for an image are detections."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.nn.nms import suppress


@dataclass(frozen=True)
class SelectionRule:
    """When a box is a detection.

    Args:
        least_score: Boxes must score higher.
        overlap: Boxes of a class that overlap more than this suppress each other.

    Raises:
        ConfigurationError: A number beyond 0..1.
    """

    least_score: float = 0.05
    overlap: float = 0.5

    def __post_init__(self) -> None:
        if not (0 <= self.least_score <= 1 and 0 <= self.overlap <= 1):
            raise ConfigurationError(f"scores and overlaps are in 0..1, got {self}")


@dataclass(frozen=True, eq=False)
class SelectedBoxes:
    """M detections of an image, best first.

    Args:
        boxes: x1, y1, x2, y2, pixels, shape (M, 4).
        scores: The scores, shape (M,).
        classes: The classes, from 0 on, shape (M,).
    """

    boxes: Tensor
    scores: Tensor
    classes: Tensor


def select(boxes: Tensor, scores: Tensor, rule: SelectionRule) -> SelectedBoxes:
    """What survives score and suppression, each class by itself.

    Args:
        boxes: The boxes for each of N places and K classes, shape (N, K, 4); one for all of them is
            (N, 1, 4).
        scores: The scores, shape (N, K).
        rule: What survives.
    """
    boxes = boxes.expand(*scores.shape, 4)
    found = []
    for label in range(scores.shape[1]):
        likely = (scores[:, label] > rule.least_score).nonzero()[:, 0]
        kept = likely[suppress(boxes[likely, label], scores[likely, label], rule.overlap)]
        found.append((boxes[kept, label], scores[kept, label], torch.full_like(kept, label)))
    columns = [torch.cat(column) for column in zip(*found, strict=True)]
    order = torch.argsort(columns[1], descending=True, stable=True)
    return SelectedBoxes(*(column[order] for column in columns))
