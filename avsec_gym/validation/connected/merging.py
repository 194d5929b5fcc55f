"""The base station's complete set of regions: those of all vehicles in the world, each once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import rectangle_iou, rectangle_overlap
from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.validation.connected.regions import Regions

DUPLICATE_IOU = 0.2
"""Intersection over union, from above, beyond which two regions are one."""


def regions_in_world(regions: Regions, pose: Floats) -> Regions:
    """Regions of a vehicle's frame, in the world; a tilt of the vehicle leaves them upright.

    Args:
        regions: The regions, in the vehicle's frame.
        pose: Tr of the vehicle, shape (4, 4).

    Example:
        >>> ahead = Regions(np.array([[5.0, 0, 0]]), np.ones((1, 3)), np.zeros(1))
        >>> left = np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        >>> regions_in_world(ahead, left).centre.tolist()
        [[0.0, 5.0, 0.0]]
    """
    turned = np.arctan2(pose[1, 0], pose[0, 0])
    centre = regions.centre @ pose[:3, :3].T + pose[:3, 3]
    return Regions(centre, regions.size, wrap_angle(regions.heading + turned))


def merged_regions(
    proposed: Sequence[Regions], duplicate_iou: float = DUPLICATE_IOU, most: int | None = None
) -> Regions:
    """All regions of all vehicles, duplicates joined.

    The region that has most in common with the others stands for all that overlap it: of three
    vehicles' boxes about one object the one in the middle, so that an outlier moves nothing.

    Args:
        proposed: The regions of each vehicle, world frame, the surest first.
        duplicate_iou: Intersection over union from above beyond which two are joined.
        most: The largest number that is kept, those first that most proposals agree on; None: all.

    Returns:
        World frame.
    """
    if not any(len(regions) for regions in proposed):
        return Regions.empty()
    every = Regions(
        np.concatenate([regions.centre for regions in proposed]),
        np.concatenate([regions.size for regions in proposed]),
        np.concatenate([regions.heading for regions in proposed]),
    )
    overlap = rectangle_iou(*2 * (seen_from_above(every),))
    agreement = np.where(overlap > duplicate_iou, overlap, 0.0).sum(axis=1)
    chosen: list[int] = []
    is_joined = np.zeros(len(every), bool)
    for index in np.argsort(-agreement, kind="stable"):
        if not is_joined[index]:
            chosen.append(int(index))
            is_joined |= overlap[index] > duplicate_iou
    return every[np.array(chosen[:most])]


def seen_from_above(regions: Regions) -> Floats:
    """Rectangles x, y, length, width, heading, as `box_overlap` takes them, shape (N, 5)."""
    return np.concatenate(
        [regions.centre[:, :2], regions.size[:, :2], regions.heading[:, None]], axis=1
    )


def stands_in(regions: Regions, pose: Floats) -> NDArray[np.bool_]:
    """Whether a vehicle itself stands in each region, of which its rays see nothing, shape (R,).

    Args:
        regions: R regions, world frame.
        pose: Tr of the vehicle, shape (4, 4).
    """
    own = np.array([*pose[:2, 3], *_OWN, np.arctan2(pose[1, 0], pose[0, 0])])
    return np.asarray(rectangle_overlap(seen_from_above(regions), own[None])[:, 0] > 0)


_OWN = (6.0, 2.8)
"""Length and width about a vehicle's sensor in which its own body stands, metres."""
