"""Proposals by plain loops, and boxes as seen from proposals."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.geometry import bird_eye_iou, camera_to_ego
from avsec_gym.perception.detectors.pointrcnn.bin_coding import BinCoding
from avsec_gym.perception.detectors.pointrcnn.configuration import ProposalRule
from avsec_gym.perception.detectors.pointrcnn.proposal_network import PointOutput
from avsec_gym.perception.detectors.pointrcnn.proposals import (
    in_proposals,
    overlaps,
    point_boxes,
    proposals,
    refined_boxes,
)

CODING = BinCoding()


@pytest.fixture
def output() -> PointOutput:
    generator = torch.Generator().manual_seed(0)
    points = torch.rand(1, 200, 3, generator=generator) * torch.tensor([8, 1, 70.0])
    codes = torch.randn(1, 200, 76, generator=generator) * 0.2
    logits = torch.randn(1, 200, generator=generator)
    return PointOutput(points, torch.zeros(1, 200, 4), logits, codes)


def kept(boxes: Tensor, rule: ProposalRule) -> list[int]:
    """Rows of boxes, sorted best first, that a plain loop keeps."""
    result = []
    depth = boxes[:, 2]
    shares = (rule.near_share, 1 - rule.near_share)
    masks = ((depth > 0) & (depth <= rule.near), (depth > rule.near) & (depth <= 2 * rule.near))
    poses = camera_to_ego(boxes[:, :3], boxes[:, 6] if rule.is_turned else 0 * boxes[:, 6])
    sizes = boxes[:, [5, 4]].numpy()
    for share, mask in zip(shares, masks, strict=True):
        stays: list[int] = []
        for row in mask.nonzero()[:, 0].tolist()[: round(share * rule.before)]:
            shared = bird_eye_iou(poses[stays], sizes[stays], poses[[row]], sizes[[row]])
            if (shared <= rule.most_overlap).all():
                stays.append(row)
        result += stays[: round(share * rule.after)]
    return sorted(result)


@pytest.mark.parametrize("is_turned", [False, True])
def test_the_best_near_and_far_ones_unlike_each_other(output: PointOutput, is_turned: bool) -> None:
    rule = ProposalRule(100, 20, 0.2, is_turned=is_turned)
    [found] = proposals(output, CODING, rule)
    order = torch.argsort(output.scores[0], descending=True, stable=True)
    boxes = point_boxes(output.points[0, order], output.codes[0, order], CODING)
    expected = kept(boxes, rule)
    torch.testing.assert_close(found.boxes, boxes[expected])
    torch.testing.assert_close(found.scores, output.scores[0, order][expected])
    assert (found.boxes[:, 2] > 40).sum() == 6
    assert len(found.boxes) == 20


def test_without_far_ones_the_next_near_ones_take_their_place(output: PointOutput) -> None:
    near = PointOutput(
        output.points * torch.tensor([1, 1, 0.4]), output.features, output.logits, output.codes
    )
    [found] = proposals(near, CODING, ProposalRule(100, 20, 0.99))
    assert len(found.boxes) == 20


def test_a_bottom_is_half_a_height_under_the_middle() -> None:
    codes = torch.zeros(1, 76)
    codes[0, [6, 18]], codes[0, 48] = 9.0, 0.3
    (box,) = point_boxes(torch.tensor([[1.0, 2.0, 30.0]]), codes, CODING)
    height = 1.52563191462
    expected = [1.25, 2.3 + height / 2, 30.25, height, 1.62856739989, 3.88311640418, 0]
    assert box.tolist() == pytest.approx(expected, abs=1e-5)


def test_seen_from_a_proposal_and_back() -> None:
    coding = BinCoding(1.5, 0.5, 9, is_fine=True)
    codes = torch.randn(40, 46, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    given = torch.from_numpy(
        np.random.default_rng(0).uniform([-9, 1, 4, 1, 1, 3, -3], [9, 2, 40, 2, 2, 5, 3], (40, 7))
    )
    refined = refined_boxes(given, codes, coding)
    told = coding.decode(codes)
    told[:, 3:6] = told[:, 3:6].clamp(min=0.1)
    torch.testing.assert_close(in_proposals(refined, given), told)
    # A quarter turn to the left: along is away from the camera (z), across is right (x).
    proposal = torch.tensor([[1.0, 1.6, 20.0, 1.5, 1.6, 4, -np.pi / 2]])
    ahead = torch.tensor([[1.0, 1.6, 21.0, 1.5, 1.6, 4, -np.pi / 2]])
    assert in_proposals(ahead, proposal)[0, :3].tolist() == pytest.approx([1, 0, 0], abs=1e-6)


def test_overlaps_of_boxes_on_each_other_in_height() -> None:
    box = torch.tensor([[0.0, 1.6, 20, 1.5, 1.6, 4, 0.3]])
    lower = box + torch.tensor([0, 0.75, 0, 0, 0, 0, 0])
    assert overlaps(box, torch.cat([box, lower]))[0].tolist() == pytest.approx([1, 1 / 3])
