"""From logits to boxes and back (Redmon and Farhadi, 2018, section 2.1).

b_x = sigmoid(t_x) + c_x in cells, b_w = p_w exp(t_w) in pixels, likewise y and h.  Boxes are x1,
y1, x2, y2, the last pixel counted in, as in `avsec_gym.perception.nn.box_coding`.
"""

from __future__ import annotations

import torch
from torch import Tensor

from avsec_gym.perception.detectors.yolo.network import YoloOutput

_LARGEST = 6.0
"""The largest of t_w and t_h: no box is four hundred times as wide as its prior."""


def decoded_boxes(output: YoloOutput) -> Tensor:
    """Shape (B, P, 4)."""
    centre = (output.logits[..., :2].sigmoid() + output.cells) * output.strides
    half = output.logits[..., 2:4].clamp(max=_LARGEST).exp() * output.priors / 2
    return torch.cat((centre - half, centre + half - 1), -1)


def place_in_cells(boxes: Tensor, output: YoloOutput, index: Tensor) -> tuple[Tensor, Tensor]:
    """The logits that stand for boxes.

    Args:
        boxes: The boxes, shape (N, 4).
        output: The output for its cells and priors.
        index: The index of the output's box that stands for each, shape (N,).

    Returns:
        sigmoid(t_x) and sigmoid(t_y), t_w and t_h, shape (N, 2) each.
    """
    size = boxes[:, 2:] - boxes[:, :2] + 1
    centre = boxes[:, :2] + size / 2
    offset = centre / output.strides[index] - output.cells[index]
    return offset, torch.log(size / output.priors[index])
