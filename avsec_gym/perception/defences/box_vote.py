"""One list of boxes of several: what most of them agree on, at the median place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from avsec_gym.box_overlap import ground_rectangles, rectangle_iou
from avsec_gym.boxes import Boxes3D

_SAME = 0.25
"""Least intersection over union, seen from above, of two boxes that are one object."""


def boxes_by_vote(found: Sequence[Boxes3D]) -> Boxes3D:
    """The objects that more than half of several looks at one scene have.

    Boxes of one category that overlap from above are one object, best score first.  Its numbers are
    the medians over the looks that have it (median smoothing, Chiang et al. 2020), so that few that
    were misled move it little; its score is the mean over all looks, 0 in those without it.

    Args:
        found: The boxes of each look; where something was found, with 2D boxes and alpha in all, or
            in none.

    Returns:
        The objects, best score first.
    """
    looks = np.repeat(np.arange(len(found)), [len(each) for each in found])
    # Who finds nothing may not have said what kind of nothing.
    boxes = Boxes3D.concatenate([each for each in found if len(each)] or found[:1])
    order = np.argsort(-boxes.score, kind="stable")
    looks, boxes = looks[order], boxes[order]
    corners = ground_rectangles(boxes.location, boxes.dimensions, boxes.rotation_y)
    same = rectangle_iou(corners, corners) >= _SAME
    same &= boxes.category[:, None] == boxes.category
    free, kept = np.ones(len(boxes), bool), []
    for best in range(len(boxes)):
        if not free[best]:
            continue
        # Of each look the surest box that is still free.
        near = np.flatnonzero(free & (same[best] | (np.arange(len(boxes)) == best)))
        _, first = np.unique(looks[near], return_index=True)
        members = near[first]
        free[members] = False
        if 2 * len(members) > len(found):
            kept.append(_median(boxes, best, members, len(found)))
    if not kept:
        return boxes[:0]
    voted = Boxes3D.concatenate(kept)
    return voted[np.argsort(-voted.score, kind="stable")]


def _median(boxes: Boxes3D, best: int, members: np.ndarray, looks: int) -> Boxes3D:
    """One box of several; what has no median is the best one's."""
    some, one = boxes[members], boxes[[best]]

    def angle(values: np.ndarray) -> np.ndarray:
        turned = (values[members] - values[best] + np.pi) % (2 * np.pi) - np.pi
        return np.atleast_1d(values[best] + np.median(turned))

    return replace(
        one,
        location=np.median(some.location, axis=0)[None],
        dimensions=np.median(some.dimensions, axis=0)[None],
        rotation_y=angle(boxes.rotation_y),
        score=np.array([some.score.sum() / looks]),
        box2d=None if some.box2d is None else np.median(some.box2d, axis=0)[None],
        alpha=None if boxes.alpha is None else angle(boxes.alpha),
    )
