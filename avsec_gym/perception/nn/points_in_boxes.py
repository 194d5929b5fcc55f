"""Which points are in upright boxes.

A box is a row ``x, y, z, height, width, length, rotation_y`` in the camera frame, as in KITTI's
labels: the place is that of its bottom's middle, y points down.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.kernels import kernel


def in_box_frames(points: Tensor, boxes: Tensor) -> Tensor:
    """Points as seen from boxes: along, down from the bottom (so mostly negative), and across.

    Args:
        points: The points, shape (..., N, 3).
        boxes: The boxes, shape (..., 7).

    Returns:
        Shape (..., N, 3).
    """
    aside = points - boxes[..., None, :3]
    cos, sin = torch.cos(boxes[..., None, 6]), torch.sin(boxes[..., None, 6])
    x, y, z = aside.unbind(-1)
    return torch.stack([cos * x - sin * z, y, sin * x + cos * z], -1)


def points_in_boxes(points: Tensor, boxes: Tensor) -> Tensor:
    """Whether points are in boxes, or on their surface.

    Args:
        points: The points, shape (N, 3).
        boxes: The boxes, shape (M, 7).

    Returns:
        Shape (M, N).
    """
    along, down, across = in_box_frames(points[None], boxes).unbind(-1)
    height, width, length = boxes[:, 3:6, None].unbind(1)
    is_beside = (along.abs() <= length / 2) & (across.abs() <= width / 2)
    return is_beside & (down <= 0) & (down >= -height)


def enlarged(boxes: Tensor, margin: float) -> Tensor:
    """Boxes larger by a margin in metres at each of their six sides, shape (M, 7)."""
    grown = boxes.clone()
    grown[:, 1] += margin
    grown[:, 3:6] += 2 * margin
    return grown


def first_inside(inside: Tensor, count: int) -> Tensor:
    """The first points in each box, in their order, from the first on again where they are few.

    Args:
        inside: Whether a point is in a box, shape (M, N).
        count: How many are taken.

    Returns:
        Indices, all 0 for an empty box, shape (M, count).
    """
    index = _first(inside.cpu().contiguous().numpy(), count)
    return torch.from_numpy(index).to(inside.device)


@kernel(nogil=True)
def _first(inside: NDArray[np.bool_], count: int) -> NDArray[np.int64]:
    index = np.zeros((len(inside), count), np.int64)
    for box in range(len(inside)):
        found = 0
        for point in range(inside.shape[1]):
            if inside[box, point]:
                index[box, found] = point
                found += 1
                if found == count:
                    break
        # What is left is filled with the same points over again.
        if found > 0:
            for place in range(found, count):
                index[box, place] = index[box, place - found]
    return index
