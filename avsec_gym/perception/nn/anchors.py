"""Anchors: the boxes that every cell of a feature pyramid may turn into an object."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor


def pyramid_anchors(
    shapes: Sequence[Sequence[int]],
    strides: Sequence[int],
    sizes: Sequence[float],
    ratios: Sequence[float],
    scales: Sequence[float] = (1.0,),
) -> Tensor:
    """Anchors of all levels, level by level, row by row, scale by scale, ratio by ratio.

    Args:
        shapes: Height and width of each level.
        strides: The pixels between neighbouring cells of each level.
        sizes: Square root of the area at each level, pixels.
        ratios: Width over height.
        scales: The scales of each level's size: two of them, 1 and the root of 2, halve its steps.

    Returns:
        x1, y1, x2, y2, float64, shape (A, 4), centred at cell x stride without half a stride.
    """
    root = torch.tensor(ratios, dtype=torch.float64).sqrt()
    own = torch.tensor(scales, dtype=torch.float64)[:, None]
    unit = torch.stack((own * root, own / root), -1).reshape(-1, 2)
    anchors = []
    for (rows, columns), size, stride in zip(shapes, sizes, strides, strict=True):
        half = size * unit / 2
        v, u = torch.meshgrid(
            torch.arange(rows) * stride, torch.arange(columns) * stride, indexing="ij"
        )
        centre = torch.stack((u, v), -1).reshape(-1, 1, 2)
        anchors.append(torch.cat((centre - half, centre + half), -1).reshape(-1, 4))
    return torch.cat(anchors)


def per_anchor(channels: Tensor, numbers: int) -> Tensor:
    """(B, anchors * numbers, H, W) to (B, H * W * anchors, numbers)."""
    return channels.permute(0, 2, 3, 1).reshape(len(channels), -1, numbers)
