"""Proposals against a plain loop; boxes and deltas there and back."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from avsec_gym.perception.detectors.stereo_rcnn.proposals import (
    decode_stereo,
    encode_stereo,
    propose,
)
from avsec_gym.perception.detectors.stereo_rcnn.stereo_rpn import StereoRpnOutput
from avsec_gym.perception.nn.box_coding import clip_boxes
from avsec_gym.perception.nn.region_counts import ProposalCount


def _boxes(count: int, seed: int) -> Tensor:
    generator = torch.Generator().manual_seed(seed)
    corner = 70 * torch.rand(count, 2, generator=generator, dtype=torch.float64)
    size = 10 + 20 * torch.rand(count, 2, generator=generator, dtype=torch.float64)
    return torch.cat((corner, corner + size), 1)


def _output(anchors: Tensor, deltas: Tensor, scores: Tensor) -> StereoRpnOutput:
    return StereoRpnOutput(torch.zeros(*scores.shape, 2), scores, deltas, anchors, 60, 90)


def test_decoding_by_hand() -> None:
    anchor = torch.tensor([10.0, 20.0, 29.0, 59.0])  # 20 x 40 pixels about (20, 40)
    deltas = torch.tensor([0.5, 0.25, math.log(2), 0.0, -0.5, math.log(0.5)])
    left, right = decode_stereo(anchor, anchor, deltas)
    torch.testing.assert_close(left, torch.tensor([10.0, 30.0, 50.0, 70.0]))
    torch.testing.assert_close(right, torch.tensor([5.0, 30.0, 15.0, 70.0]))


def test_the_right_box_has_the_rows_of_the_left_one() -> None:
    anchors, deltas = _boxes(50, 0), torch.randn(50, 6, dtype=torch.float64) / 2
    left, right = decode_stereo(anchors, anchors, deltas)
    torch.testing.assert_close(left[:, [1, 3]], right[:, [1, 3]])


def test_exact_decoding_undoes_encoding() -> None:
    left, right, true_left, true_right = (_boxes(50, seed) for seed in range(1, 5))
    for first, second in ((left, right), (true_left, true_right)):
        second[:, [1, 3]] = first[:, [1, 3]]
    deltas = encode_stereo(left, right, true_left, true_right)
    exact = decode_stereo(left, right, deltas, exact=True)
    torch.testing.assert_close(exact, (true_left, true_right))
    published = decode_stereo(left, right, deltas)
    wider = torch.tensor([0.0, 0.0, 1.0, 1.0])
    torch.testing.assert_close(published, (true_left + wider, true_right + wider))


def test_agrees_with_a_plain_loop() -> None:
    """Suppressed in either view is suppressed; survivors stay in the order of scores."""
    generator = torch.Generator().manual_seed(3)
    anchors = _boxes(80, 4)
    deltas = 0.3 * torch.randn(2, 80, 6, generator=generator, dtype=torch.float64)
    scores = torch.rand(2, 80, generator=generator, dtype=torch.float64)
    proposals = propose(_output(anchors, deltas, scores), ProposalCount(70, 40), 0.4)
    for pair in range(2):
        left, right = decode_stereo(anchors, anchors, deltas[pair])
        best = scores[pair].argsort(descending=True)[:70].tolist()
        views = [clip_boxes(boxes, 60, 90) for boxes in (left, right)]
        survivors = [_survivors(boxes, best, 0.4) for boxes in views]
        expected = [k for k in best if all(k in kept for kept in survivors)][:40]
        count = int(proposals.valid[pair].sum())
        assert 10 < count == len(expected)
        assert len(expected) < min(len(kept) for kept in survivors)
        torch.testing.assert_close(proposals.left[pair, :count], views[0][expected])
        torch.testing.assert_close(proposals.right[pair, :count], views[1][expected])
        torch.testing.assert_close(proposals.scores[pair, :count], scores[pair, expected])
        assert proposals.valid[pair, :count].all()
        assert (proposals.left[pair, count:] == 0).all()


def _survivors(boxes: Tensor, order: list[int], overlap: float) -> list[int]:
    kept: list[int] = []
    for k in order:
        shared = [
            (boxes[[k, j], 2:].amin(0) - boxes[[k, j], :2].amax(0) + 1).clamp(min=0).prod()
            for j in kept
        ]
        area = [(boxes[j, 2:] - boxes[j, :2] + 1).prod() for j in (*kept, k)]
        if all(s / (a + area[-1] - s) <= overlap for s, a in zip(shared, area, strict=False)):
            kept.append(k)
    return kept


def test_proposals_stay_within_the_image_and_carry_no_gradient() -> None:
    deltas = (3 * torch.randn(1, 120, 6, dtype=torch.float64)).requires_grad_()
    output = _output(_boxes(120, 5), deltas, torch.rand(1, 120, dtype=torch.float64))
    proposals = propose(output, ProposalCount(120, 120), 0.7)
    for boxes in (proposals.left, proposals.right):
        assert not boxes.requires_grad
        assert boxes.min() >= 0
        assert boxes[..., [0, 2]].max() <= 89
        assert boxes[..., [1, 3]].max() <= 59


def test_pairs_with_a_small_box_are_dropped_and_the_others_stay() -> None:
    anchors, scores = _boxes(60, 7), torch.rand(1, 60, dtype=torch.float64)
    deltas = torch.randn(1, 60, 6, dtype=torch.float64)
    every = propose(_output(anchors, deltas, scores), ProposalCount(60, 60), 1.0)
    large = propose(_output(anchors, deltas, scores), ProposalCount(60, 60), 1.0, least_side=9.0)
    sides = [(boxes[0, :, 2:] - boxes[0, :, :2]).amin(1) for boxes in (every.left, every.right)]
    kept = every.valid[0] & (sides[0] >= 9) & (sides[1] >= 9)
    assert 5 < kept.sum() < every.valid.sum() - 5
    torch.testing.assert_close(large.left[large.valid], every.left[0, kept])
    torch.testing.assert_close(large.right[large.valid], every.right[0, kept])
