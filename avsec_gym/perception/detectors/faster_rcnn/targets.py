"""What the network should learn to give: sampled anchors, regions and their targets.

A `RegionSamples` holds every choice that is not differentiable (which anchors, which regions,
which object each belongs to), so that with one of them fixed the loss is a function of the pixels
alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from avsec_gym.perception.detectors.faster_rcnn.region_proposals import RegionProposals, RpnOutput
from avsec_gym.perception.detectors.image_truth import ImageTruth
from avsec_gym.perception.nn.box_coding import encode_boxes, overlaps
from avsec_gym.perception.nn.region_counts import SampleCount
from avsec_gym.perception.nn.region_sampling import (
    anchor_labels,
    sampled_labels,
    sampled_regions,
)

BOX_DEVIATIONS = (0.1, 0.1, 0.2, 0.2)
"""The box head's deltas are given in these units."""

_REGION_OVERLAP = 0.5


@dataclass(frozen=True, eq=False)
class RegionSamples:
    """Samples of B images with A anchors and R sampled regions each.

    Args:
        anchor_labels: 1 object, 0 background, -1 not sampled, shape (B, A).
        anchor_targets: Deltas to the object's box, shape (B, A, 4).
        regions: The regions, shape (B, R, 4).
        labels: Class of each region, 0 the background, shape (B, R).
        box_targets: The box targets as `BoxOutput.deltas`; 0 on the background, shape (B, R, 4).
    """

    anchor_labels: Tensor
    anchor_targets: Tensor
    regions: Tensor
    labels: Tensor
    box_targets: Tensor


@torch.no_grad()
def draw_sampling(
    rpn: RpnOutput,
    proposals: RegionProposals,
    truths: Sequence[ImageTruth],
    count: SampleCount,
    generator: torch.Generator | None,
) -> RegionSamples:
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
        found = proposals.regions[image, proposals.valid[image]]
        regions = torch.cat([found, truth.boxes])
        rows.append(
            _anchor_targets(rpn, truth, count, generator)
            + _region_targets(regions, truth, count, generator)
        )
    return RegionSamples(*(torch.stack(column) for column in zip(*rows, strict=True)))


def _anchor_targets(
    rpn: RpnOutput, truth: ImageTruth, count: SampleCount, generator: torch.Generator | None
) -> tuple[Tensor, Tensor]:
    targets = torch.zeros_like(rpn.deltas[0])
    labels, owner = anchor_labels(rpn.anchors, truth.boxes)
    labels[(labels == 0) & _meets(rpn.anchors, truth.ignored)] = -1
    if len(truth.boxes):
        targets = encode_boxes(rpn.anchors, truth.boxes[owner])
    return sampled_labels(labels, count, generator), targets


def _region_targets(
    regions: Tensor, truth: ImageTruth, count: SampleCount, generator: torch.Generator | None
) -> tuple[Tensor, Tensor, Tensor]:
    """Regions, labels and targets as in `RegionSamples`."""
    true = torch.zeros(len(regions), dtype=torch.bool, device=regions.device)
    owner = torch.zeros(len(regions), dtype=torch.long, device=regions.device)
    if len(truth.boxes):
        most, owner = overlaps(regions, truth.boxes).max(1)
        true = most >= _REGION_OVERLAP
    false = ~true & ~_meets(regions, truth.ignored)
    picked = sampled_regions(true, false, count, generator)
    regions, owner, on = regions[picked], owner[picked], true[picked]
    labels = torch.zeros_like(owner)
    targets = torch.zeros_like(regions)
    if len(truth.boxes):
        of = owner[on]
        labels[on] = truth.classes[of] + 1
        deltas = encode_boxes(regions[on], truth.boxes[of])
        targets[on] = deltas / regions.new_tensor(BOX_DEVIATIONS)
    return regions, labels, targets


def _meets(boxes: Tensor, ignored: Tensor) -> Tensor:
    """Which boxes lie on what is neither object nor background, shape (N,)."""
    if not len(ignored):
        return torch.zeros(len(boxes), dtype=torch.bool, device=boxes.device)
    return (overlaps(boxes, ignored) >= _REGION_OVERLAP).any(1)
