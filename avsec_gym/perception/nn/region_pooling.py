"""Features of regions, each from a level of the pyramid."""

from __future__ import annotations

import torch
from torch import Tensor

from avsec_gym.perception.nn.feature_pyramid import FeaturePyramid
from avsec_gym.perception.nn.roi_align import roi_align

FINEST, COARSEST = 2, 5
"""Levels that regions are pooled from: P2..P5."""


def pooled_regions(
    pyramid: FeaturePyramid, regions: Tensor, level: Tensor, bins: int, sampling_ratio: int
) -> Tensor:
    """ROI align of every region on its own level.

    Args:
        pyramid: The pyramid of B images.
        regions: x1, y1, x2, y2, pixels of the network's input, shape (B, N, 4).
        level: 2..5, shape (B * N,).
        bins: The number of bins along a side.
        sampling_ratio: Samples along an axis of a bin; 0 adapts to the bin.

    Returns:
        Features, shape (B * N, C, bins, bins).
    """
    count, each = regions.shape[:2]
    levels = pyramid.levels[: COARSEST - FINEST + 1]
    return roi_align(
        levels,
        regions.detach().reshape(-1, 4),
        torch.arange(count, device=regions.device).repeat_interleave(each),
        level - FINEST,
        bins,
        [features.shape[-2] / pyramid.height for features in levels],
        sampling_ratio,
    )
