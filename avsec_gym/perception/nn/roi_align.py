"""ROI align (He et al., Mask R-CNN, 2017): features of boxes, averaged over a grid of bins.

The samples of all boxes are rows of one table that holds every level and image, and a bin is a
weighted sum of rows, so that boxes of any shape on any level are pooled by one operation.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import torch
from torch import Tensor
from torch.nn import functional

SamplePlaces = Literal["centres", "corners"]


def roi_align(
    levels: Sequence[Tensor],
    boxes: Tensor,
    image: Tensor,
    level: Tensor,
    bins: int,
    scales: Sequence[float],
    sampling_ratio: int = 0,
    places: SamplePlaces = "centres",
) -> Tensor:
    """Pool each box from the level it belongs to; differentiable to the features.

    Args:
        levels: Feature maps of B images, each of shape (B, C, H_l, W_l).
        boxes: x1, y1, x2, y2 in pixels of the images, shape (N, 4); no gradient reaches them.
        image: Index of each box's image, shape (N,).
        level: Index of each box's feature map, shape (N,).
        bins: The number of bins along a side of the output.
        scales: The scales of each level, feature cells over pixels.
        sampling_ratio: Samples along an axis of a bin; 0 takes as many as the bin has cells,
            rounded up.
        places: Samples stand within the bins (Stereo R-CNN's branch 1.0, as in
            maskrcnn-benchmark: no shift by half a cell, boxes of at least one cell), or on the
            bins' four corners (its branch master: boxes are one cell larger, outside is zero).

    Returns:
        Shape (N, C, bins, bins).
    """
    channels = levels[0].shape[1]
    if not len(boxes):
        return levels[0].new_zeros(0, channels, bins, bins)
    # All cells of all levels are rows of one table; `first_row` is where a box's own map begins.
    table = torch.cat([features.permute(0, 2, 3, 1).reshape(-1, channels) for features in levels])
    shapes = torch.tensor(
        [(features.shape[-2], features.shape[-1]) for features in levels], device=boxes.device
    )
    cells = shapes.prod(1)
    level_start = (cells * len(levels[0])).cumsum(0) - cells * len(levels[0])
    first_row = level_start[level] + image * cells[level]

    # Boxes in cells of their own level, rows before columns.
    scaled = boxes.detach() * boxes.new_tensor(scales)[level, None]
    start = scaled[:, :2].flip(1)
    size = scaled[:, 2:].flip(1) - start
    size = (size + 1).clamp(min=0) if places == "corners" else size.clamp(min=1)
    ratios = _samples_along(size, bins, sampling_ratio, places)

    groups, pooled = [], []
    for ratio in torch.unique(ratios, dim=0):  # boxes with equally many samples
        chosen = (ratios == ratio).all(1).nonzero()[:, 0]
        extent = shapes[level[chosen]]
        (row, row_weight), (column, column_weight) = (
            _samples(
                start[chosen, axis],
                size[chosen, axis],
                extent[:, axis],
                bins,
                int(ratio[axis]),
                places,
            )
            for axis in (0, 1)
        )
        width = extent[:, 1, None, None]
        index = (row * width)[:, :, None, :, None] + column[:, None, :, None, :]
        weight = row_weight[:, :, None, :, None] * column_weight[:, None, :, None, :]
        bags = (len(chosen) * bins * bins, -1)
        sums = functional.embedding_bag(
            (index + first_row[chosen, None, None, None, None]).reshape(bags),
            table,
            per_sample_weights=weight.reshape(bags).to(table.dtype),
            mode="sum",
        )
        groups.append(chosen)
        pooled.append(sums.reshape(-1, bins, bins, channels))
    order = torch.argsort(torch.cat(groups))
    return torch.cat(pooled)[order].permute(0, 3, 1, 2)


def _samples_along(size: Tensor, bins: int, sampling_ratio: int, places: SamplePlaces) -> Tensor:
    """Number of samples along each axis of a bin, for boxes of a size in cells, shape (N, 2)."""
    if places == "corners":
        return torch.full_like(size, 2, dtype=torch.long)
    if sampling_ratio > 0:
        return torch.full_like(size, sampling_ratio, dtype=torch.long)
    return (size / bins).ceil().long()


def _samples(
    start: Tensor, size: Tensor, extent: Tensor, bins: int, ratio: int, places: SamplePlaces
) -> tuple[Tensor, Tensor]:
    """Cells along one axis that a bin takes from, and their shares, shape (N, bins, 2 * ratio)."""
    within = torch.arange(ratio, device=start.device, dtype=start.dtype)
    within = within if places == "corners" else (within + 0.5) / ratio
    steps = torch.arange(bins, device=start.device, dtype=start.dtype)[:, None] + within
    position = start[:, None, None] + steps * (size / bins)[:, None, None]
    last = (extent - 1).to(start.dtype)[:, None, None]
    if places == "corners":
        inside = (position >= 0) & (position < last + 1)
    else:
        inside = (position >= -1) & (position <= last + 1)
        position = position.clamp(min=0).minimum(last)
    lower = position.floor().clamp(min=0).minimum((last - 1).clamp(min=0))
    share = (position - lower) * (last > 0)
    weight = torch.stack((1 - share, share), -1) * (inside.to(share.dtype) / ratio)[..., None]
    cell = torch.stack((lower, (lower + 1).minimum(last)), -1).long()
    return cell.flatten(2), weight.flatten(2)
