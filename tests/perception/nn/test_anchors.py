"""Anchors by hand and by plain loops."""

from __future__ import annotations

import math
from itertools import product

import torch

from avsec_gym.perception.nn.anchors import per_anchor, pyramid_anchors


def test_published_anchors() -> None:
    shapes = [(4, 5), (2, 3), (1, 2), (1, 1), (1, 1)]
    anchors = pyramid_anchors(shapes, (4, 8, 16, 32, 64), (32, 64, 128, 256, 512), (0.5, 1.0, 2.0))
    assert anchors.shape == (3 * (20 + 6 + 2 + 1 + 1), 4)
    # Second row, third column of P2: centred at (8, 4), without half a stride.
    cell = anchors[3 * (5 + 2) : 3 * (5 + 3)]
    assert torch.allclose((cell[:, :2] + cell[:, 2:]) / 2, torch.tensor([8.0, 4.0]).double())
    width, height = (cell[:, 2:] - cell[:, :2]).unbind(1)
    assert torch.allclose(width * height, torch.tensor(32.0**2).double())
    assert torch.allclose(width / height, torch.tensor([0.5, 1.0, 2.0]).double())
    second_level = anchors[3 * 20 + 1]
    assert second_level.tolist() == [-32, -32, 32, 32]


def test_anchors_by_plain_loops() -> None:
    shapes, strides, sizes, ratios = [(3, 4), (2, 2)], (4, 8), (10.0, 20.0), (0.5, 2.0)
    scales = (1.0, 1.5, 1.7)
    expected = []
    for (rows, columns), stride, size in zip(shapes, strides, sizes, strict=True):
        for row in range(rows):
            for column in range(columns):
                for side, ratio in product([size * scale for scale in scales], ratios):
                    width, height = side * math.sqrt(ratio), side / math.sqrt(ratio)
                    u, v = column * stride, row * stride
                    corners = (u - width / 2, v - height / 2, u + width / 2, v + height / 2)
                    expected.append(corners)
    found = pyramid_anchors(shapes, strides, sizes, ratios, scales)
    torch.testing.assert_close(found, torch.tensor(expected, dtype=torch.float64))


def test_channels_follow_the_order_of_anchors() -> None:
    """Channel c of a cell is number c % 4 of its anchor c // 4."""
    maps = torch.randn(2, 3 * 4, 5, 6)
    rows = per_anchor(maps, 4)
    for row, column, anchor, number in ((0, 0, 0, 0), (2, 5, 1, 3), (4, 1, 2, 2)):
        found = rows[1, (row * 6 + column) * 3 + anchor, number]
        assert found == maps[1, anchor * 4 + number, row, column]
