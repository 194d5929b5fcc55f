"""Non-maximum suppression of axis-aligned boxes."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.kernels import kernel


def suppress(boxes: Tensor, scores: Tensor, overlap: float) -> Tensor:
    """Indices of the boxes that survive, best score first.

    A box falls if a better one that survives overlaps it by more than a given share; of equal
    scores, the first is the better.

    Args:
        boxes: x1, y1, x2, y2, pixels, the last pixel counted in (width = x2 - x1 + 1),
            shape (N, 4).
        scores: The scores, shape (N,).
        overlap: Intersection over union.

    Returns:
        Shape (M,), on the boxes' device.
    """
    order = torch.argsort(scores, descending=True, stable=True)
    return order[surviving(boxes[order], overlap)]


def surviving(boxes: Tensor, overlap: float) -> Tensor:
    """Which boxes survive, of boxes sorted from best to worst, shape (N,), bool; see `suppress`."""
    kept = _surviving(boxes.detach().cpu().contiguous().numpy(), overlap)
    return torch.from_numpy(kept).to(boxes.device)


@kernel(nogil=True)
def _surviving(boxes: NDArray[Any], overlap: float) -> NDArray[np.bool_]:
    count = len(boxes)
    kept = np.ones(count, np.bool_)
    area = (boxes[:, 2] - boxes[:, 0] + 1) * (boxes[:, 3] - boxes[:, 1] + 1)
    # Invariant: of the boxes before `best`, those still kept are the survivors.
    for best in range(count):
        if not kept[best]:
            continue
        x1, y1, x2, y2 = boxes[best]
        for other in range(best + 1, count):
            if not kept[other]:
                continue
            width = min(x2, boxes[other, 2]) - max(x1, boxes[other, 0]) + 1
            height = min(y2, boxes[other, 3]) - max(y1, boxes[other, 1]) + 1
            if width > 0 and height > 0:
                shared = width * height
                kept[other] = shared <= overlap * (area[best] + area[other] - shared)
    return kept
