"""The targets of DSGN for a scene: which anchors stand for which object (Chen et al., section 3.4).

An anchor is as far from an object as their bottom corners are on average, corner by corner; so an
anchor that points the other way is far, unless anchors stand for both.  An object takes as many of
the nearest anchors as its footprint covers cells, cars a quarter of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.perception.detectors.dsgn.anchors import anchor_footprints, corners_of_boxes
from avsec_gym.perception.detectors.dsgn.box_field import AnchorIndex
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration

_REACH = 5.0
"""Metres: an anchor farther from an object than this never stands for it."""
_SHARES = {"Car": 0.25}
"""The share of the cells under an object, how many anchors stand for it; 1 for other classes."""
_COUNTS_AS = {"Van": "Car", "Person_sitting": "Pedestrian"}
_MOST_TRUNCATED = 0.98


@dataclass(frozen=True, eq=False)
class AnchorTargets:
    """The P anchors of a batch that stand for an object; all others stand for background.

    Args:
        index: Image, angle, class, row and column of each, int64, shape (P,): it picks them from
            the class logits of `DsgnOutput`.
        corners: The corners of their objects, less the anchor's place, shape (P, 8, 3), metres.
        centerness: How close each is to its object, 1 for the closest, shape (P,).
        reversed: 1 where the object heads the other way than its corners show, 0 elsewhere, shape
            (P,).  With half turns, corners are those of the box or of the box turned round, whose
            are closer to the anchor's.
    """

    index: AnchorIndex
    corners: Tensor
    centerness: Tensor
    reversed: Tensor

    def to(self, like: Tensor) -> AnchorTargets:
        """The targets on the device of a tensor, with its floating type."""
        image, angle, category, row, column = (part.to(like.device) for part in self.index)
        return AnchorTargets(
            (image, angle, category, row, column),
            self.corners.to(like),
            self.centerness.to(like),
            self.reversed.to(like),
        )


def anchor_targets(
    truth: Sequence[Boxes3D], configuration: DsgnConfiguration, categories: Sequence[str] = ("Car",)
) -> AnchorTargets:
    """The anchors that stand for the objects of a batch.

    Where two objects want one anchor, the nearer to the camera has it.  As in the original, the
    centerness of an anchor is exp(-(d - least d of that object)) for the object at the least
    distance d from it, which need not be the one it stands for.

    Args:
        truth: Objects of each pair; a Van counts as a Car, a Person_sitting as a Pedestrian;
            other categories, and what is truncated by 98 % or more, are left out.
        configuration: Anchors and grid.
        categories: Classes to be learned, among those of the anchors.
    """
    parts = [_of_image(boxes, configuration, categories) for boxes in truth]
    images = [np.full(len(part[1]), image) for image, part in enumerate(parts)]
    index = np.stack([np.concatenate(images), *np.concatenate([part[0] for part in parts], axis=1)])
    image, angle, category, row, column = torch.from_numpy(index)
    return AnchorTargets(
        (image, angle, category, row, column),
        torch.from_numpy(np.concatenate([part[1] for part in parts])),
        torch.from_numpy(np.concatenate([part[2] for part in parts])),
        torch.from_numpy(np.concatenate([part[3] for part in parts])),
    )


def _of_image(
    boxes: Boxes3D, configuration: DsgnConfiguration, categories: Sequence[str]
) -> tuple[NDArray[np.int64], Floats, Floats, Floats]:
    """Angle, class, row and column (4, P), corners (P, 8, 3), centerness and reversal (P,)."""
    boxes, classes = objects_to_learn(boxes, configuration, categories)
    ways = _ways(boxes, configuration)
    bottoms = np.ascontiguousarray(ways[:, :, :4][..., [0, 2]])
    footprints = anchor_footprints(configuration)
    owner, least = _owners(boxes, classes, bottoms, footprints, configuration)
    positive = np.stack(np.nonzero(owner >= 0))
    angle, kind, row, column = positive
    owners = owner[angle, kind, row, column]
    heights = np.array([anchor.centre_y for anchor in configuration.anchors])
    x, z = configuration.grid.x.centres(), configuration.grid.z.centres()
    place = np.stack([x[column], heights[kind], z[row]], axis=-1)[:, None]
    # From every object, each compared with the anchor of its own class.
    moved = place[:, None, :, ::2] + footprints[classes[None, :], angle[:, None]]
    distances = np.linalg.norm(moved[:, None] - bottoms, axis=-1).mean(axis=-1)  # (P, ways, N)
    each = np.arange(len(owners))
    way = distances[each, :, owners].argmin(axis=1)
    distances = distances.min(axis=1)
    closest = distances.argmin(axis=1) if len(boxes) else owners
    excess = (distances - least)[each, closest]
    return positive, ways[way, owners] - place, np.exp(-excess), way.astype(float)


def _ways(boxes: Boxes3D, configuration: DsgnConfiguration) -> Floats:
    """Corners of the boxes, and with half turns of the boxes turned round, (1 or 2, N, 8, 3)."""
    turned = [boxes]
    if configuration.half_turns:
        turned.append(replace(boxes, rotation_y=boxes.rotation_y + np.pi))
    return np.stack([corners_of_boxes(boxes) for boxes in turned])


def _owners(
    boxes: Boxes3D,
    classes: NDArray[np.int64],
    bottoms: Floats,
    footprints: Floats,
    configuration: DsgnConfiguration,
) -> tuple[NDArray[np.int32], Floats]:
    """The object of each anchor or -1, (A, K, Z, X), and each object's least distance (N,).

    `bottoms` are those of `_ways`, of which the nearer counts, shape (1 or 2, N, 4, 2).
    """
    x, z = configuration.grid.x.centres(), configuration.grid.z.centres()
    cell = abs((x[1] - x[0]) * (z[1] - z[0]))
    owner = np.full(
        (configuration.angles, len(configuration.anchors), len(z), len(x)), -1, np.int32
    )
    least = np.full(len(boxes), _REACH)
    for i, kind in enumerate(classes):
        # No anchor's corners are nearer on average than its centre.
        rows = np.flatnonzero(np.abs(z - boxes.location[i, 2]) < _REACH)
        columns = np.flatnonzero(np.abs(x - boxes.location[i, 0]) < _REACH)
        distances = np.min(
            [_distances(x[columns], z[rows], footprints[kind], way[i]) for way in bottoms], axis=0
        )
        share = _SHARES.get(configuration.anchors[kind].category, 1.0)
        count = max(int(share * boxes.width[i] * boxes.length[i] / cell), 1)
        near = np.flatnonzero(distances < _REACH)
        nearest = near[np.argsort(distances.ravel()[near], kind="stable")[:count]]
        angle, row, column = np.unravel_index(nearest, distances.shape)
        owner[angle, kind, rows[row], columns[column]] = i
        least[i] = distances.ravel()[nearest].min(initial=_REACH)
    return owner, least


def objects_to_learn(
    boxes: Boxes3D, configuration: DsgnConfiguration, categories: Sequence[str]
) -> tuple[Boxes3D, NDArray[np.int64]]:
    """The objects by class, and from far to near in each, and their classes."""
    numbers = {
        anchor.category: i
        for i, anchor in enumerate(configuration.anchors)
        if anchor.category in categories
    }
    names = [_COUNTS_AS.get(name, name) for name in boxes.category.tolist()]
    classes = np.array([numbers.get(name, -1) for name in names], np.int64)
    kept = classes >= 0
    if boxes.truncation is not None:
        kept &= boxes.truncation < _MOST_TRUNCATED
    order = np.lexsort((-boxes.location[:, 2], classes))
    order = order[kept[order]]
    return boxes[order], classes[order]


@kernel(nogil=True)
def _distances(x: Floats, z: Floats, footprints: Floats, bottom: Floats) -> Floats:
    """Of the anchors at cells (z, x) from an object, shape (angles, len(z), len(x))."""
    result = np.empty((len(footprints), len(z), len(x)))
    for angle in range(len(footprints)):
        for row in range(len(z)):
            for column in range(len(x)):
                total = 0.0
                for k in range(4):
                    dx = x[column] + footprints[angle, k, 0] - bottom[k, 0]
                    dz = z[row] + footprints[angle, k, 1] - bottom[k, 1]
                    total += np.sqrt(dx * dx + dz * dz)
                result[angle, row, column] = total / 4
    return result
