"""From the boxes of points to proposals: the best of them, few alike, near ones and far ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avsec_gym.box_overlap import box_iou, ground_rectangles
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.pointrcnn.bin_coding import BinCoding
from avsec_gym.perception.detectors.pointrcnn.configuration import ProposalRule
from avsec_gym.perception.detectors.pointrcnn.proposal_network import PointOutput
from avsec_gym.perception.nn.points_in_boxes import in_box_frames
from avsec_gym.perception.nn.rotated_nms import rotated_nms

_SMALLEST = 0.1
"""Metres: no untrained network's box has no size."""


@dataclass(frozen=True, eq=False)
class ScanProposals:
    """The proposals of one scan, best score first.

    Args:
        boxes: Rows as `points_in_boxes` takes them, camera frame, shape (M, 7).
        scores: Probabilities, shape (M,).
    """

    boxes: Tensor
    scores: Tensor


@torch.no_grad()
def proposals(output: PointOutput, coding: BinCoding, rule: ProposalRule) -> list[ScanProposals]:
    """Where objects may be, for each scan.

    Args:
        output: The output of the first stage.
        coding: The coding of its boxes.
        rule: The rule by which boxes are taken.
    """
    found = []
    for points, codes, scores in zip(output.points, output.codes, output.scores, strict=True):
        boxes = point_boxes(points, codes.float(), coding)
        order = torch.argsort(scores, descending=True, stable=True)
        chosen = order[_chosen(boxes[order], scores[order], rule)]
        found.append(ScanProposals(boxes[chosen], scores[chosen]))
    return found


def point_boxes(points: Tensor, codes: Tensor, coding: BinCoding) -> Tensor:
    """Boxes (N, 7) of points (N, 3), decoded from codes (N, channels)."""
    boxes = _with_size(coding.decode(codes))
    boxes[:, :3] += points
    boxes[:, 1] += boxes[:, 3] / 2
    return boxes


def refined_boxes(boxes: Tensor, codes: Tensor, coding: BinCoding) -> Tensor:
    """Boxes (N, 7) decoded from codes (N, channels), each in the frame of a given box (N, 7)."""
    refined = _with_size(coding.decode(codes))
    along, across = refined[:, 0], refined[:, 2]
    cos, sin = torch.cos(boxes[:, 6]), torch.sin(boxes[:, 6])
    x, z = cos * along + sin * across, cos * across - sin * along
    refined[:, :3] = boxes[:, :3] + torch.stack([x, refined[:, 1], z], 1)
    refined[:, 6] += boxes[:, 6]
    return refined


def in_proposals(boxes: Tensor, given: Tensor) -> Tensor:
    """The inverse of the last: boxes (N, 7), each as seen from a given box (N, 7)."""
    places = in_box_frames(boxes[:, None, :3], given)[:, 0]
    return torch.cat([places, boxes[:, 3:6], boxes[:, 6:] - given[:, 6:]], 1)


def overlaps(boxes: Tensor, others: Tensor) -> Tensor:
    """Intersection over union of volumes, shape (N, M), on the boxes' device."""
    one, two = (rows.detach().double().cpu().numpy() for rows in (boxes, others))
    iou = box_iou(one[:, :3], one[:, 3:6], one[:, 6], two[:, :3], two[:, 3:6], two[:, 6])
    return torch.from_numpy(iou).to(boxes)


def from_above(boxes: Tensor) -> Floats:
    """Rectangles of boxes, as `avsec_gym.box_overlap` takes them, shape (N, 5)."""
    rows = boxes.detach().double().cpu().numpy()
    return ground_rectangles(rows[:, :3], rows[:, 3:6], rows[:, 6])


def _with_size(boxes: Tensor) -> Tensor:
    return torch.cat([boxes[:, :3], boxes[:, 3:6].clamp(min=_SMALLEST), boxes[:, 6:]], 1)


def _chosen(boxes: Tensor, scores: Tensor, rule: ProposalRule) -> Tensor:
    """Indices of boxes that are sorted from best to worst; so are these."""
    rectangles, sure = from_above(boxes), scores.double().cpu().numpy()
    if not rule.is_turned:
        rectangles[:, 4] = 0.0
    depth = boxes[:, 2].cpu().numpy()
    near = np.flatnonzero((depth > 0) & (depth <= rule.near))
    far = np.flatnonzero((depth > rule.near) & (depth <= 2 * rule.near))
    before, after = (int(rule.near_share * count) for count in (rule.before, rule.after))
    if not len(far):
        near, far = near[:before], near[before:]
    chosen = []
    for rows, enter, stay in (
        (near, before, after),
        (far, rule.before - before, rule.after - after),
    ):
        rows = rows[:enter]
        stays = rotated_nms(rectangles[rows], sure[rows], rule.most_overlap)[:stay]
        chosen.append(rows[stays])
    return torch.from_numpy(np.sort(np.concatenate(chosen))).to(boxes.device)
