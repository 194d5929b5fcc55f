"""Boxes of an image by their corners, and what turns one into another: deltas (Girshick, 2014).

x1, y1, x2, y2 in pixels, the last pixel counted in: width = x2 - x1 + 1.
"""

from __future__ import annotations

import torch
from torch import Tensor


def encode_boxes(boxes: Tensor, truth: Tensor) -> Tensor:
    """The deltas that turn boxes (..., 4) into true ones (..., 4), shape (..., 4)."""
    size, centre = _size_and_centre(boxes)
    true_size, true_centre = _size_and_centre(truth)
    return torch.cat(((true_centre - centre) / size, torch.log(true_size / size)), -1)


def decode_boxes(boxes: Tensor, deltas: Tensor, last: float = 1.0) -> Tensor:
    """What deltas dx, dy, dw, dh make of boxes (..., 4).

    Args:
        boxes: The boxes, shape (..., 4).
        deltas: The deltas, shape (..., 4).
        last: 1 undoes `encode_boxes`; with 0, as in much published code, a box of w pixels ends at
            x1 + w.
    """
    size, centre = _size_and_centre(boxes)
    half = torch.exp(deltas[..., 2:]) * size / 2
    centre = deltas[..., :2] * size + centre
    return torch.cat((centre - half, centre + half - last), -1)


def clip_boxes(boxes: Tensor, height: int, width: int) -> Tensor:
    """Boxes (..., 4) within an image: 0..width - 1, 0..height - 1."""
    last = boxes.new_tensor([width - 1, height - 1, width - 1, height - 1])
    return boxes.clamp(min=0).minimum(last)


def shorter_side(boxes: Tensor) -> Tensor:
    """The shorter side of boxes (..., 4), the last pixel not counted, shape (...)."""
    return (boxes[..., 2:] - boxes[..., :2]).amin(-1)


def overlaps(boxes: Tensor, others: Tensor) -> Tensor:
    """Intersection over union of boxes (N, 4) and (M, 4), shape (N, M)."""
    first = torch.maximum(boxes[:, None, :2], others[None, :, :2])
    last = torch.minimum(boxes[:, None, 2:], others[None, :, 2:])
    common = (last - first + 1).clamp(min=0).prod(-1)
    return common / (_area(boxes)[:, None] + _area(others)[None] - common)


def _area(boxes: Tensor) -> Tensor:
    return (boxes[:, 2:] - boxes[:, :2] + 1).prod(-1)


def _size_and_centre(boxes: Tensor) -> tuple[Tensor, Tensor]:
    size = boxes[..., 2:] - boxes[..., :2] + 1
    return size, boxes[..., :2] + size / 2
