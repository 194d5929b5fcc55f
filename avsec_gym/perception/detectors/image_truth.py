"""What an image truly shows, as detectors of single images learn it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avsec_gym.boxes import Boxes3D
from avsec_gym.kitti.labels import DONT_CARE

_ALIKE = {"Car": "Van", "Pedestrian": "Person_sitting"}
"""So much like an object that KITTI takes a detection of it for neither right nor wrong."""
_SMALLEST_SIDE = 4.0
_MOST_OCCLUDED = 3
"""KITTI's level of unknown occlusion."""


@dataclass(frozen=True, eq=False)
class ImageTruth:
    """The objects of an image, in pixels of the network's input.

    Args:
        boxes: x1, y1, x2, y2, shape (N, 4).
        classes: The classes, from 0 on, shape (N,).
        ignored: Boxes of what is neither object nor background, shape (M, 4).
    """

    boxes: Tensor
    classes: Tensor
    ignored: Tensor


def image_truth(
    labels: Boxes3D, categories: Sequence[str], scale: tuple[float, float], like: Tensor
) -> ImageTruth:
    """The objects to be learned, and those to be left alone: alike, tiny, or hidden.

    Args:
        labels: The labels, with 2D boxes in pixels of the image.
        categories: What is detected.
        scale: The network's input is so many times as high and as wide as the image.
        like: The tensor whose type and device the result gets.
    """
    if labels.box2d is None:  # Nothing is there, then.
        labels = labels[:0]
    box2d = np.zeros((0, 4)) if labels.box2d is None else labels.box2d
    boxes = (box2d + 0.5) * np.array([scale[1], scale[0]] * 2) - 0.5
    classes = np.full(len(labels), -1)
    for number, name in enumerate(categories):
        classes[labels.category == name] = number
    alike = [_ALIKE[name] for name in categories if name in _ALIKE]
    ignored = np.isin(labels.category, [name for name in alike if name not in categories])
    ignored |= labels.category == DONT_CARE
    unclear = (boxes[:, 2:] - boxes[:, :2]).min(axis=1, initial=np.inf) < _SMALLEST_SIDE
    if labels.occlusion is not None:
        unclear |= labels.occlusion >= _MOST_OCCLUDED
    learned = (classes >= 0) & ~unclear
    ignored |= (classes >= 0) & unclear
    return ImageTruth(
        torch.as_tensor(boxes[learned], dtype=like.dtype, device=like.device),
        torch.as_tensor(classes[learned], device=like.device),
        torch.as_tensor(boxes[ignored], dtype=like.dtype, device=like.device),
    )
