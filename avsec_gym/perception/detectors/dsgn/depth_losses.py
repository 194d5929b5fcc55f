"""What DSGN's depth costs: the original's loss, and one that minds single planes and objects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.dsgn.losses import at_least_single

_MARGIN = 0.1
"""Metres around a box within which a pixel still belongs to its object."""


def depth_loss(depth: Tensor, true_depth: Tensor, near: float, far: float) -> Tensor:
    """Mean smooth L1 error of depths.

    Args:
        depth: The depths, metres, any shape.
        true_depth: The same shape; only pixels in (near, far] count.
        near: The least depth, metres.
        far: The greatest depth, metres.
    """
    known = (true_depth > near) & (true_depth <= far)
    if not known.any():
        return 0.0 * depth.sum()
    return functional.smooth_l1_loss(at_least_single(depth)[known], true_depth[known])


def plane_loss(logits: Tensor, bins: Tensor, true_depth: Tensor, weight: Tensor) -> Tensor:
    """Cross entropy of depths, averaged with weights over all pixels whose depth lies in the bins.

    The two bins beside the true depth share the target, so that its expectation is that depth:
    other than the error of an expectation, it also costs to believe in two surfaces at once.

    Args:
        logits: The logits of D bins (dimension 1), shape (B, D, h, w).
        bins: The bins, metres, from far to near, shape (D,).
        true_depth: The true depths, metres, 0 where unknown, shape (B, h, w).
        weight: The weight of each pixel, positive, shape (B, h, w).
    """
    known = (true_depth >= bins[-1]) & (true_depth <= bins[0])
    if not known.any():
        return 0.0 * logits.sum()
    depth, weight = true_depth[known], weight[known]
    rising = bins.flip(0)
    above = torch.searchsorted(rising, depth).clamp(1, len(bins) - 1)
    share = (depth - rising[above - 1]) / (rising[above] - rising[above - 1])
    surprise = -at_least_single(logits).log_softmax(1).movedim(1, -1)[known].flip(1)
    farther, nearer = (surprise.gather(1, which[:, None])[:, 0] for which in (above, above - 1))
    return (weight * (share * farther + (1 - share) * nearer)).sum() / weight.sum()


@torch.no_grad()
def on_objects(depth: Tensor, projection: Tensor, objects: Sequence[Boxes3D], step: int) -> Tensor:
    """Which pixels show an object: those whose place in space lies in its box, or just beside it.

    Args:
        depth: The depths of every ``step``-th pixel, metres, 0 where unknown, shape (B, h, w).
        projection: P of the camera for all pixels, shape (B, 3, 4).
        objects: The objects of each image.
        step: The pixels between two depths.

    Returns:
        A mask, shape (B, h, w).
    """
    height, width = depth.shape[1:]
    v, u = torch.meshgrid(
        step * torch.arange(height).to(depth), step * torch.arange(width).to(depth), indexing="ij"
    )
    p = projection.to(depth)
    # P (x, y, z, 1) = depth (u, v, 1)
    seen = depth[:, None] * torch.stack([u, v, torch.ones_like(u)]) - p[:, :, 3, None, None]
    places = torch.einsum("bij,bjvu->bivu", torch.linalg.inv(p[:, :, :3]), seen)
    found = torch.zeros_like(depth, dtype=torch.bool)
    # The first object of all images, then the second of all that have one, ...
    for boxes in torch.from_numpy(_in_rows(objects)).to(depth):
        x, y, z, h, w, length, yaw = (part[:, None, None] for part in boxes.unbind(-1))
        x, y, z = places[:, 0] - x, places[:, 1] - y, places[:, 2] - z
        along, across, up = x * yaw.cos() - z * yaw.sin(), x * yaw.sin() + z * yaw.cos(), -y
        found |= (
            (along.abs() <= length / 2 + _MARGIN)
            & (across.abs() <= w / 2 + _MARGIN)
            & (up >= -_MARGIN)
            & (up <= h + _MARGIN)
        )
    return found & (depth > 0)


def _in_rows(objects: Sequence[Boxes3D]) -> Floats:
    """Place, size and yaw of the i-th object of each image, (most, B, 7); NaN where is none."""
    most = max((len(boxes) for boxes in objects), default=0)
    rows = np.full((most, len(objects), 7), np.nan)
    for image, boxes in enumerate(objects):
        numbers = [boxes.location, boxes.dimensions, boxes.rotation_y[:, None]]
        rows[: len(boxes), image] = np.concatenate(numbers, axis=1)
    return rows
