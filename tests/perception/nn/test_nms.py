"""Non-maximum suppression against a plain loop."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from avsec_gym.perception.nn.nms import suppress, surviving


def _overlap(first: list[float], second: list[float]) -> float:
    """Of boxes whose last pixel is counted in."""
    width = min(first[2], second[2]) - max(first[0], second[0]) + 1
    height = min(first[3], second[3]) - max(first[1], second[1]) + 1
    if width <= 0 or height <= 0:
        return 0.0
    areas = [(box[2] - box[0] + 1) * (box[3] - box[1] + 1) for box in (first, second)]
    return width * height / (sum(areas) - width * height)


def _plain(boxes: Tensor, scores: Tensor, overlap: float) -> list[int]:
    kept: list[int] = []
    for i in sorted(range(len(boxes)), key=lambda i: (-scores[i].item(), i)):
        if all(_overlap(boxes[i].tolist(), boxes[j].tolist()) <= overlap for j in kept):
            kept.append(i)
    return kept


@pytest.mark.parametrize("overlap", [0.1, 0.3, 0.7])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_agrees_with_a_plain_loop(overlap: float, dtype: torch.dtype) -> None:
    generator = torch.Generator().manual_seed(1)
    corner = 20 * torch.rand(80, 2, generator=generator, dtype=dtype)
    size = 10 + 20 * torch.rand(80, 2, generator=generator, dtype=dtype)
    boxes = torch.cat((corner, corner + size), 1)
    scores = torch.randint(0, 30, (80,), generator=generator) / 30  # many are equal
    kept = suppress(boxes, scores, overlap)
    assert kept.tolist() == _plain(boxes, scores, overlap)
    assert 1 < len(kept) < len(boxes)


def test_the_last_pixel_counts() -> None:
    """Two boxes of 2 x 2 pixels that share one column overlap by a third."""
    boxes = torch.tensor([[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 2.0, 1.0]])
    assert surviving(boxes, 0.34).tolist() == [True, True]
    assert surviving(boxes, 0.33).tolist() == [True, False]


def test_a_suppressed_box_suppresses_nothing() -> None:
    boxes = torch.tensor([[0.0, 0.0, 9.0, 9.0], [4.0, 0.0, 13.0, 9.0], [8.0, 0.0, 17.0, 9.0]])
    assert suppress(boxes, torch.tensor([0.9, 0.8, 0.7]), 0.3).tolist() == [0, 2]


def test_nothing_in_nothing_out() -> None:
    assert len(suppress(torch.zeros(0, 4), torch.zeros(0), 0.5)) == 0
