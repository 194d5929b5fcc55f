"""Which anchors lie on an object, and which of them are learned from (Ren et al., 2015, 3.1)."""

from __future__ import annotations

import torch
from torch import Tensor

from avsec_gym.perception.nn.box_coding import overlaps
from avsec_gym.perception.nn.region_counts import SampleCount

_SURELY, _SURELY_NOT = 0.7, 0.3


def anchor_labels(
    anchors: Tensor, objects: Tensor, image: tuple[int, int] | None = None
) -> tuple[Tensor, Tensor]:
    """Whether anchors lie on an object, and on which.

    On one are those that overlap it by 0.7, and its best ones; on none those below 0.3 of all.

    Args:
        anchors: x1, y1, x2, y2, pixels, shape (A, 4).
        objects: The same of the true boxes, shape (N, 4).
        image: Height and width; anchors that leave it are neither (Ren et al.).  None: those count,
            too (Lin et al., Feature pyramid networks, 2017, section 4.1).

    Returns:
        1 object, 0 background, -1 neither, shape (A,); the object that each overlaps most,
        shape (A,).
    """
    inside = torch.ones(len(anchors), dtype=torch.bool, device=anchors.device)
    if image is not None:
        height, width = image
        inside = (anchors[:, :2] >= 0).all(1)
        inside &= (anchors[:, 2] < width) & (anchors[:, 3] < height)
    labels = torch.where(inside, 0, -1)
    if not len(objects):
        return labels, torch.zeros_like(labels)
    shared = overlaps(anchors, objects) * inside[:, None]
    most, owner = shared.max(1)
    best = shared.max(0).values
    labels[inside & (most >= _SURELY_NOT)] = -1
    labels[((shared == best) & (best > 0)).any(1)] = 1
    labels[most >= _SURELY] = 1
    return labels, owner


def sampled_labels(labels: Tensor, count: SampleCount, generator: torch.Generator | None) -> Tensor:
    """Labels of a sample of the anchors; -1 where one is not in it."""
    true = drawn(labels == 1, int(count.true_anchors * count.anchors), generator)
    false = drawn(labels == 0, count.anchors - len(true), generator)
    labels = torch.full_like(labels, -1)
    labels[true], labels[false] = 1, 0
    return labels


def sampled_regions(
    true: Tensor, false: Tensor, count: SampleCount, generator: torch.Generator | None
) -> Tensor:
    """Indices of regions to learn from, those on objects first, some perhaps repeatedly.

    Args:
        true: Whether a region lies on an object, shape (N,).
        false: Whether it is background, shape (N,).
        count: How many.
        generator: A generator of the CPU; None: torch's own.
    """
    positive = drawn(true, round(count.true_regions * count.regions), generator)
    if not false.any():
        # Without any background, the sample is filled up with objects, as published.
        false = true if len(positive) else torch.ones_like(true)
    rest = _drawn_again(false, count.regions - len(positive), generator)
    return torch.cat([positive, rest])


def drawn(mask: Tensor, most: int, generator: torch.Generator | None) -> Tensor:
    """Ascending indices of a mask (N,): at most so many, drawn where there are more."""
    index = mask.nonzero()[:, 0]
    if len(index) <= most:
        return index
    return index[
        torch.randperm(len(index), generator=generator)[:most].sort().values.to(index.device)
    ]


def _drawn_again(mask: Tensor, number: int, generator: torch.Generator | None) -> Tensor:
    """So many indices of a mask (N,), each drawn anew."""
    index = mask.nonzero()[:, 0]
    return index[torch.randint(len(index), (number,), generator=generator).to(index.device)]
