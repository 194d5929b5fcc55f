"""Plane-sweep volumes: what both views show if the scene lay on each of a row of planes.

And the way from the costs of the planes to one number for each pixel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn import functional


def disparity_volume(left: Tensor, right: Tensor, planes: int) -> Tensor:
    """PSMNet's volume: both features laid together at every whole disparity.

    Args:
        left: Features of the left image, shape (B, C, H, W).
        right: The same shape.
        planes: Disparities 0, 1, ... in pixels of the features.

    Returns:
        Shape (B, 2C, planes, H, W); zero, in both halves, where the right image does not reach.
    """
    width = left.shape[-1]
    slices = []
    for disparity in range(planes):
        overlap = max(width - disparity, 0)
        pair = torch.cat([left[..., width - overlap :], right[..., :overlap]], 1)
        slices.append(functional.pad(pair, (width - overlap, 0)))
    return torch.stack(slices, 2)


def sampled_volume(left: Tensor, right: Tensor, disparities: Tensor) -> Tensor:
    """DSGN's volume: the right features sampled at any disparities, the left ones repeated.

    Args:
        left: Features of the left image, shape (B, C, H, W).
        right: The same shape.
        disparities: The disparities of the D planes for each pair, pixels of the features, >= 0,
            shape (B, D).

    Returns:
        Shape (B, 2C, D, H, W): the left half repeats the left features, whatever the plane; the
        right half is the right features at ``x - disparity``, linear between columns, zero
        outside.
    """
    planes = disparities.shape[1]
    pairs = [
        torch.stack([shifted(features, shift) for shift in shifts], 1)
        for features, shifts in zip(right, disparities.tolist(), strict=True)
    ]
    repeated = left.unsqueeze(2).expand(-1, -1, planes, -1, -1)
    return torch.cat([repeated, torch.stack(pairs)], 1)


def enlarged(costs: Tensor, size: Sequence[int], aligned_corners: bool) -> Tensor:
    """Trilinear interpolation, along the planes first: a third of the time of torch's own.

    Args:
        costs: The costs, shape (B, D, h, w).
        size: New D, H and W.
        aligned_corners: Whether the centres of the outermost cells stay where they are.

    Returns:
        Shape (B, D, H, W).
    """
    planes, *place = size
    batch, _, height, width = costs.shape
    between = functional.interpolate(
        costs.flatten(2)[:, None],
        size=(planes, height * width),
        mode="bilinear",
        align_corners=aligned_corners,
    )
    return functional.interpolate(
        between.reshape(batch, planes, height, width),
        size=tuple(place),
        mode="bilinear",
        align_corners=aligned_corners,
    )


def expectation(logits: Tensor, values: Tensor) -> Tensor:
    """The mean of values (D,) under the softmax of logits (B, D, H, W): shape (B, H, W)."""
    return (logits.softmax(1) * values[:, None, None]).sum(1)


def shifted(features: Tensor, shift: float) -> Tensor:
    """Features (C, H, W) moved to the right by a shift that need not be whole; zeros move in."""
    width = features.shape[-1]
    first = min(math.ceil(shift), width)
    weight, count = first - shift, width - first
    moved = features[..., :count]
    if weight > 0 and count > 0:
        moved = torch.lerp(moved, features[..., 1 : count + 1], weight)
    return functional.pad(moved, (first, 0))
