"""PointRCNN's training loss, term by term, of both stages at once."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.perception.detectors.pointrcnn.bin_coding import BinCoding
from avsec_gym.perception.detectors.pointrcnn.network import PointRcnnNetwork
from avsec_gym.perception.detectors.pointrcnn.proposal_network import PointOutput
from avsec_gym.perception.detectors.pointrcnn.refinement_network import (
    RefinementOutput,
    region_points,
)
from avsec_gym.perception.detectors.pointrcnn.targets import (
    PointTargets,
    RegionTargets,
    joined,
    point_targets,
    region_targets,
)

_POSITIVE_WEIGHT, _FOCUS = 0.25, 2.0
"""The weight of positives and the focus of the focal loss (Lin et al., ICCV 2017)."""
_SIZE_WEIGHT = 3.0


def pointrcnn_losses(
    network: PointRcnnNetwork,
    points: Tensor,
    objects: Sequence[Tensor],
    ignored: Sequence[Tensor | None] | None = None,
) -> dict[str, Tensor]:
    """The terms of both stages, scalars; the second learns from a sample of the first's proposals.

    Args:
        network: The network in training mode.
        points: Camera frame, shape (B, N, 3).
        objects: The objects of each scan, rows as `points_in_boxes` takes them, (M, 7) each.
        ignored: Other boxes of each scan whose points are not judged.
    """
    configuration = network.configuration
    output = network.rpn(points)
    targets = [
        point_targets(cloud, boxes, configuration.ignored_margin, others)
        for cloud, boxes, others in zip(
            points, objects, ignored or [None] * len(objects), strict=True
        )
    ]
    terms = proposal_losses(output, targets, configuration.coding)
    regions = [
        region_targets(proposed.boxes, boxes, configuration.sampling)
        for proposed, boxes in zip(network.propose(output), objects, strict=True)
    ]
    pooled = region_points(output, [part.regions for part in regions], configuration)
    refined = network.rcnn_net(pooled)
    coding = configuration.refinement.coding
    return terms | refinement_losses(refined, joined(regions), pooled.is_empty, coding)


def proposal_losses(
    output: PointOutput, targets: Sequence[PointTargets], coding: BinCoding
) -> dict[str, Tensor]:
    """The terms `segmentation`, `proposal_place`, `proposal_heading` and `proposal_size`.

    Args:
        output: The output of the first stage, B scans.
        targets: The targets of each.
        coding: The coding of its boxes.
    """
    labels = torch.cat([target.labels for target in targets])
    boxes = torch.cat([target.boxes for target in targets])
    on_object = labels == 1
    logits = output.logits.float().flatten()
    surprise = functional.binary_cross_entropy_with_logits(
        logits, on_object.float(), reduction="none"
    )
    weight = torch.where(on_object, _POSITIVE_WEIGHT, 1 - _POSITIVE_WEIGHT)
    focal = weight * (1 - torch.exp(-surprise)) ** _FOCUS * surprise
    segmentation = focal[labels >= 0].sum() / on_object.sum().clamp(min=1)
    codes = output.codes.float().flatten(0, 1)
    terms = box_losses(codes[on_object], boxes[on_object], coding)
    named = {f"proposal_{name}": term for name, term in terms.items()}
    return {"segmentation": segmentation, **named}


def refinement_losses(
    output: RefinementOutput, targets: RegionTargets, is_empty: Tensor, coding: BinCoding
) -> dict[str, Tensor]:
    """The terms `confidence`, `refined_place`, `refined_heading` and `refined_size`.

    Args:
        output: The output of the second stage, R proposals.
        targets: The targets of the same.
        is_empty: Proposals without points, of which nothing is learned, shape (R,).
        coding: The coding of its boxes.
    """
    judged = (targets.labels >= 0) & ~is_empty
    surprise = functional.binary_cross_entropy_with_logits(
        output.logits.float(), (targets.labels == 1).float(), reduction="none"
    )
    confidence = surprise[judged].sum() / judged.sum().clamp(min=1)
    chosen = targets.has_box & ~is_empty
    terms = box_losses(output.codes.float()[chosen], targets.boxes[chosen], coding)
    named = {f"refined_{name}": term for name, term in terms.items()}
    return {"confidence": confidence, **named}


def box_losses(codes: Tensor, boxes: Tensor, coding: BinCoding) -> dict[str, Tensor]:
    """The terms `place`, `heading` and `size`, means over N boxes; 0 where there is none.

    Args:
        codes: Predicted, shape (N, channels).
        boxes: True ones, as `BinCoding.targets` takes them, shape (N, 7).
        coding: The coding of both.
    """
    if not len(codes):
        return dict.fromkeys(("place", "heading", "size"), codes.sum())
    predicted, true = coding.parts(codes), coding.targets(boxes)
    distance = functional.smooth_l1_loss
    place = distance(predicted.y[:, 0], true.y)
    for bins, right, residuals, residual in (
        (predicted.x_bins, true.x_bin, predicted.x, true.x),
        (predicted.z_bins, true.z_bin, predicted.z, true.z),
    ):
        place = place + _bin_loss(bins, right, residuals, residual)
    return {
        "place": place,
        "heading": _bin_loss(
            predicted.heading_bins, true.heading_bin, predicted.heading, true.heading
        ),
        "size": _SIZE_WEIGHT * distance(predicted.size, true.size),
    }


def _bin_loss(bins: Tensor, right: Tensor, residuals: Tensor, residual: Tensor) -> Tensor:
    """Which bin, and where in the right one."""
    at_right = residuals.gather(1, right[:, None])[:, 0]
    return functional.cross_entropy(bins, right) + functional.smooth_l1_loss(at_right, residual)
