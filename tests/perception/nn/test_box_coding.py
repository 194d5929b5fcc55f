"""Boxes and deltas there and back; overlaps against shapely."""

from __future__ import annotations

import math

import pytest
import torch
from shapely import box as rectangle
from torch import Tensor

from avsec_gym.perception.nn.box_coding import (
    clip_boxes,
    decode_boxes,
    encode_boxes,
    overlaps,
    shorter_side,
)


def _boxes(count: int, seed: int) -> Tensor:
    generator = torch.Generator().manual_seed(seed)
    corner = 40 * torch.rand(count, 2, generator=generator, dtype=torch.float64)
    size = 5 + 20 * torch.rand(count, 2, generator=generator, dtype=torch.float64)
    return torch.cat((corner, corner + size), 1)


def test_decoding_by_hand() -> None:
    box = torch.tensor([10.0, 20.0, 29.0, 59.0])  # 20 x 40 pixels about (20, 40)
    deltas = torch.tensor([0.5, 0.25, math.log(2), 0.0])
    torch.testing.assert_close(decode_boxes(box, deltas), torch.tensor([10.0, 30.0, 49.0, 69.0]))
    published = decode_boxes(box, deltas, last=0.0)
    torch.testing.assert_close(published, torch.tensor([10.0, 30.0, 50.0, 70.0]))


def test_decoding_undoes_encoding() -> None:
    boxes, truth = _boxes(50, 0), _boxes(50, 1)
    torch.testing.assert_close(decode_boxes(boxes, encode_boxes(boxes, truth)), truth)


def test_overlaps_count_the_last_pixel() -> None:
    one = torch.tensor([[0.0, 0, 9, 9]])
    others = torch.tensor([[5.0, 0, 14, 9], [0, 0, 9, 9], [10, 0, 19, 9]])
    assert overlaps(one, others)[0].tolist() == pytest.approx([50 / 150, 1, 0])


def test_overlaps_agree_with_shapely() -> None:
    boxes, others = _boxes(12, 2), _boxes(9, 3)
    found = overlaps(boxes, others)
    for i, j in ((i, j) for i in range(12) for j in range(9)):
        one, two = (
            rectangle(x1, y1, x2 + 1, y2 + 1)
            for x1, y1, x2, y2 in (boxes[i].tolist(), others[j].tolist())
        )
        expected = one.intersection(two).area / one.union(two).area
        assert float(found[i, j]) == pytest.approx(expected, abs=1e-12)


def test_what_leaves_the_image_is_cut_off() -> None:
    boxes = torch.tensor([[-3.0, 2, 90, 70], [5, 6, 7, 10]])
    clipped = clip_boxes(boxes, 60, 80)
    assert clipped.tolist() == [[0, 2, 79, 59], [5, 6, 7, 10]]
    assert shorter_side(clipped).tolist() == [57, 2]
