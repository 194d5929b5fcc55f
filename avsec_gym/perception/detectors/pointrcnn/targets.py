"""The targets of points and proposals: whether they are on an object, and where that one is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avsec_gym.perception.detectors.pointrcnn.configuration import RegionSampling
from avsec_gym.perception.detectors.pointrcnn.proposals import in_proposals, overlaps
from avsec_gym.perception.nn.points_in_boxes import enlarged, points_in_boxes
from avsec_gym.perception.nn.region_sampling import drawn

_KEPT = 0.2
"""Share of the tries to shake a proposal that leave it as it is."""
_SHAKES = (
    (0.2, 0.1, np.pi / 12),
    (0.3, 0.15, np.pi / 12),
    (0.5, 0.15, np.pi / 9),
    (0.8, 0.15, np.pi / 6),
    (1.0, 0.15, np.pi / 3),
)
"""How far a proposal is moved (metres), how much resized (a share), how far turned (radians); one
of these by chance."""


@dataclass(frozen=True, eq=False)
class PointTargets:
    """Targets of N points.

    Args:
        labels: 1 on an object, 0 background, -1 neither, shape (N,).
        boxes: The boxes of the objects, from each point, for those on one only, shape (N, 7).
    """

    labels: Tensor
    boxes: Tensor


@dataclass(frozen=True, eq=False)
class RegionTargets:
    """Targets of R sampled proposals.

    Args:
        regions: The proposals, shape (R, 7).
        labels: 1 an object, 0 none, -1 in between, shape (R,).
        has_box: Whether the box is learned, shape (R,).
        boxes: The boxes of the objects they overlap most, in their own frames, shape (R, 7).
    """

    regions: Tensor
    labels: Tensor
    has_box: Tensor
    boxes: Tensor


def point_targets(
    points: Tensor, objects: Tensor, margin: float, ignored: Tensor | None = None
) -> PointTargets:
    """The targets of one scan.

    Args:
        points: The points, shape (N, 3).
        objects: Rows as `points_in_boxes` takes them, shape (M, 7).
        margin: Metres about an object in which points are neither on it nor background.
        ignored: Boxes in which they are neither as well, unless they are on an object.
    """
    boxes = points.new_zeros(len(points), 7)
    unsure = objects if ignored is None else torch.cat([objects, ignored])
    near = points_in_boxes(points, enlarged(unsure, margin)).any(0)
    labels = torch.where(near, -1, 0)
    if not len(objects):
        return PointTargets(labels, boxes)
    on_object, owner = points_in_boxes(points, objects).max(0)
    labels[on_object] = 1
    middles = objects.clone()
    middles[:, 1] -= objects[:, 3] / 2
    boxes[on_object] = middles[owner[on_object]]
    boxes[on_object, :3] -= points[on_object]
    return PointTargets(labels, boxes)


@torch.no_grad()
def region_targets(proposals: Tensor, objects: Tensor, sampling: RegionSampling) -> RegionTargets:
    """A sample of the proposals of one scan, shaken; draws from torch's own generator.

    The objects themselves are among the proposals, so that there is something to learn from
    before the first stage knows anything (Ren et al., 2015); the public code leaves them out.

    Args:
        proposals: The proposals, shape (M, 7), M at least 1.
        objects: The objects, shape (K, 7).
        sampling: How many, and which.
    """
    if not len(objects):
        everywhere = torch.ones_like(proposals[:, 0], dtype=torch.bool)
        regions = proposals[_repeatedly(everywhere, sampling.regions)]
        nothing = torch.zeros(len(regions), dtype=torch.long, device=regions.device)
        return RegionTargets(regions, nothing, nothing.bool(), torch.zeros_like(regions))
    candidates = torch.cat([proposals, objects])
    most, owner = overlaps(candidates, objects).max(1)
    chosen = _sample(most, sampling)
    regions, truth = candidates[chosen], objects[owner[chosen]]
    # Those on objects are shaken until they still are, the others once.
    tries = torch.where(most[chosen] >= sampling.least_box, sampling.shakes, 1)
    regions, shared = _shaken(regions, truth, tries, sampling.least_box)
    labels = torch.where(shared > sampling.object, 1, -1)
    labels[shared < sampling.background] = 0
    return RegionTargets(regions, labels, shared > sampling.least_box, in_proposals(truth, regions))


def joined(parts: Sequence[RegionTargets]) -> RegionTargets:
    """The targets of several scans, one after the other."""
    return RegionTargets(
        torch.cat([part.regions for part in parts]),
        torch.cat([part.labels for part in parts]),
        torch.cat([part.has_box for part in parts]),
        torch.cat([part.boxes for part in parts]),
    )


def _sample(most: Tensor, sampling: RegionSampling) -> Tensor:
    """Indices of regions by their largest overlaps: on objects, touching them, elsewhere."""
    true = most >= sampling.least_box
    hard = (most >= sampling.touching) & (most < sampling.background)
    easy = most < sampling.touching
    if not (hard.any() or easy.any()):
        return _repeatedly(true, sampling.regions)
    on_object = drawn(true, round(sampling.true_share * sampling.regions), None)
    rest = sampling.regions - len(on_object)
    touching = int(sampling.hard_share * rest) if easy.any() else rest
    touching *= int(hard.any())
    parts = [on_object]
    parts += [_repeatedly(hard, touching)] if touching else []
    parts += [_repeatedly(easy, rest - touching)] if rest > touching else []
    return torch.cat(parts)


def _repeatedly(mask: Tensor, count: int) -> Tensor:
    """So many indices of a mask (N,), each drawn anew."""
    index = mask.nonzero()[:, 0]
    return index[torch.randint(len(index), (count,)).to(index.device)]


def _shaken(boxes: Tensor, objects: Tensor, tries: Tensor, enough: float) -> tuple[Tensor, Tensor]:
    """Boxes moved by chance, until they overlap their objects enough or all tries are made.

    Returns:
        Boxes, shape (R, 7), and their overlaps with their objects, shape (R,).
    """
    result = boxes.clone()
    shared = torch.zeros_like(boxes[:, 0])
    for number in range(int(tries.max())):
        open_ = ((shared < enough) & (tries > number)).nonzero()[:, 0]
        if not len(open_):
            break
        result[open_] = _shaken_once(boxes[open_])
        shared[open_] = overlaps(result[open_], objects[open_]).diagonal()
    return result, shared


def _shaken_once(boxes: Tensor) -> Tensor:
    kinds = boxes.new_tensor(_SHAKES)[torch.randint(len(_SHAKES), (len(boxes),))]
    shift, scale, turn = torch.split(kinds, 1, dim=1)
    chance = (2 * torch.rand(len(boxes), 7) - 1).to(boxes)
    is_moved = (torch.rand(len(boxes), 1) >= _KEPT).to(boxes.device)
    moved = torch.cat(
        [
            boxes[:, :3] + shift * chance[:, :3],
            boxes[:, 3:6] * (1 + scale * chance[:, 3:6]),
            boxes[:, 6:] + turn * chance[:, 6:],
        ],
        1,
    )
    return torch.where(is_moved, moved, boxes)
