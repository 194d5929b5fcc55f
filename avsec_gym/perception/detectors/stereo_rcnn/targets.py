"""What the network should learn to give: sampled anchors, regions and targets (SPEC 3, 5).

A `PairSamples` holds every choice that is not differentiable (which anchors, which regions, which
object each belongs to), so that with one of them fixed the loss is a function of the pixels alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.stereo_rcnn.keypoints import StereoTruth
from avsec_gym.perception.detectors.stereo_rcnn.proposals import PairProposals, encode_stereo
from avsec_gym.perception.detectors.stereo_rcnn.stereo_rpn import StereoRpnOutput
from avsec_gym.perception.nn.box_coding import overlaps
from avsec_gym.perception.nn.region_counts import SampleCount
from avsec_gym.perception.nn.region_sampling import (
    anchor_labels,
    sampled_labels,
    sampled_regions,
)

BOX_DEVIATIONS = (0.1, 0.1, 0.2, 0.2, 0.1, 0.2)
"""The box head's deltas are given in these units."""
DIMENSION_MEANS = (1.6, 1.5, 4.0, 0.0, 0.0)
"""Width, height, length (metres), sin and cos of the observation angle are given less these..."""
DIMENSION_DEVIATION = 0.5
"""...and over this."""
KEYPOINT_CELLS = 28
"""The number of cells across a region of the left image."""

_REGION_OVERLAP = 0.5


@dataclass(frozen=True, eq=False)
class PairSamples:
    """Samples of B images with A anchors and R sampled regions each.

    Args:
        anchor_labels: 1 object, 0 background, -1 not sampled, shape (B, A).
        anchor_targets: Deltas to the object's two boxes, shape (B, A, 6).
        left: Regions of the left image, shape (B, R, 4).
        right: Regions of the right image, shape (B, R, 4).
        labels: Class of each region, 0 the background, shape (B, R).
        box_targets: The box targets as `BoxOutput.box_deltas`; 0 on the background, shape (B, R,
            6).
        dimension_targets: The dimension targets as `BoxOutput.dimensions_orientation`, likewise,
            shape (B, R, 5).
        keypoint_targets: Cell of the keypoint (corner x 28 + column), of the left and of the
            right border, shape (B, R, 3); -1 where there is none.
        fit_targets: How well each region's box fits, shape (B, R), NaN where that is not known;
            None: not computed yet.
    """

    anchor_labels: Tensor
    anchor_targets: Tensor
    left: Tensor
    right: Tensor
    labels: Tensor
    box_targets: Tensor
    dimension_targets: Tensor
    keypoint_targets: Tensor
    fit_targets: Tensor | None = None

    def with_keypoints(self) -> tuple[Tensor, Tensor]:
        """The K regions of each image that have any keypoint, and their targets.

        Returns:
            Regions of the left image, shape (B, K, 4), K the most of any image and 1 at least;
            targets, shape (B, K, 3), -1 throughout where an image has fewer.
        """
        order = self.keypoint_order()
        regions = torch.take_along_dim(self.left, order[..., None], 1)
        return regions, torch.take_along_dim(self.keypoint_targets, order[..., None], 1)

    def keypoint_order(self) -> Tensor:
        """Which of the R regions `with_keypoints` gives, shape (B, K)."""
        having = (self.keypoint_targets >= 0).any(-1)
        most = max(1, int(having.sum(1).max()))
        # Those that have keypoints first, in their order.
        return torch.argsort(having.int(), dim=1, descending=True, stable=True)[:, :most]


@torch.no_grad()
def draw_sampling(
    rpn: StereoRpnOutput,
    proposals: PairProposals,
    truths: Sequence[StereoTruth],
    count: SampleCount,
    generator: torch.Generator | None,
) -> PairSamples:
    """Sampled targets for a batch.

    Args:
        rpn: The proposal network's output for its anchors and the images' size.
        proposals: The proposals of the same batch.
        truths: The objects for each image, in pixels of the network's input.
        count: How many.
        generator: A generator of the CPU; equal seeds draw equal samples. None: torch's own.
    """
    rows = []
    for image, truth in enumerate(truths):
        objects = _Objects(truth, proposals.left)
        valid = proposals.valid[image]
        left = torch.cat([proposals.left[image, valid], objects.left])
        right = torch.cat([proposals.right[image, valid], objects.right])
        rows.append(
            _anchor_targets(rpn, objects, count, generator)
            + _region_targets(left, right, objects, count, generator)
        )
    return PairSamples(*(torch.stack(column) for column in zip(*rows, strict=True)))


class _Objects:
    """The truth of one image as tensors like those of the network."""

    def __init__(self, truth: StereoTruth, like: Tensor) -> None:
        def tensor(array: Floats) -> Tensor:
            return torch.as_tensor(array, dtype=like.dtype, device=like.device)

        self.left, self.right, self.union = map(tensor, (truth.left, truth.right, truth.union))
        height, width, length = truth.dimensions.T
        sizes = [width, height, length, np.sin(truth.alpha), np.cos(truth.alpha)]
        self.dimensions = tensor(np.stack(sizes, axis=1))
        self.columns = tensor(np.hstack([truth.keypoints, truth.borders]))
        self.classes = torch.as_tensor(truth.classes, device=like.device)

    def __len__(self) -> int:
        return len(self.left)


def keypoint_targets(columns: Tensor, regions: Tensor) -> Tensor:
    """Cells that regions (N, 4) should name for columns (N, 6) of the image, shape (N, 3).

    Args:
        columns: u of the four corners, NaN where there is no keypoint, and of the two borders.
        regions: The regions in the left image.
    """
    width = regions[:, 2] - regions[:, 0] + 1
    cells = torch.round((columns - regions[:, :1]) * KEYPOINT_CELLS / width[:, None])
    outside = ~((cells >= 0) & (cells <= KEYPOINT_CELLS - 1))
    cells = cells.masked_fill(outside, -1).long()
    position, corner = cells[:, :4].max(1)
    keypoint = torch.where(position < 0, position, corner * KEYPOINT_CELLS + position)
    return torch.cat([keypoint[:, None], cells[:, 4:]], 1)


def _anchor_targets(
    rpn: StereoRpnOutput, objects: _Objects, count: SampleCount, generator: torch.Generator | None
) -> tuple[Tensor, Tensor]:
    """Labels (A,) and deltas (A, 6): an anchor belongs to the object whose union box it meets."""
    anchors, targets = rpn.anchors, torch.zeros_like(rpn.deltas[0])
    labels, owner = anchor_labels(anchors, objects.union, (rpn.height, rpn.width))
    if len(objects):
        targets = encode_stereo(anchors, anchors, objects.left[owner], objects.right[owner])
    return sampled_labels(labels, count, generator), targets


def _region_targets(
    left: Tensor,
    right: Tensor,
    objects: _Objects,
    count: SampleCount,
    generator: torch.Generator | None,
) -> tuple[Tensor, ...]:
    """As in `PairSamples`: a region belongs to the object that both views meet."""
    true = torch.zeros(len(left), dtype=torch.bool, device=left.device)
    owner = torch.zeros(len(left), dtype=torch.long, device=left.device)
    false = ~true
    if len(objects):
        most_left, owner = overlaps(left, objects.left).max(1)
        most_right, owner_right = overlaps(right, objects.right).max(1)
        met = (most_left >= _REGION_OVERLAP) & (most_right >= _REGION_OVERLAP)
        true, false = met & (owner == owner_right), ~met
    picked = sampled_regions(true, false, count, generator)
    left, right, owner, on = left[picked], right[picked], owner[picked], true[picked]
    labels = torch.zeros_like(owner)
    boxes, dimensions = left.new_zeros(len(picked), 6), left.new_zeros(len(picked), 5)
    keypoints = labels.new_full((len(picked), 3), -1)
    if len(objects):
        of = owner[on]
        labels[on] = objects.classes[of]
        deltas = encode_stereo(left[on], right[on], objects.left[of], objects.right[of])
        boxes[on] = deltas / left.new_tensor(BOX_DEVIATIONS)
        sizes = objects.dimensions[of] - left.new_tensor(DIMENSION_MEANS)
        dimensions[on] = sizes / DIMENSION_DEVIATION
        keypoints[on] = keypoint_targets(objects.columns[of], left[on])
    return left, right, labels, boxes, dimensions, keypoints
