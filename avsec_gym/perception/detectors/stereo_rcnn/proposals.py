"""From the proposal network's output to pairs of regions; the coding of boxes by deltas."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from avsec_gym.perception.detectors.stereo_rcnn.stereo_rpn import StereoRpnOutput
from avsec_gym.perception.nn.box_coding import clip_boxes, decode_boxes, encode_boxes, shorter_side
from avsec_gym.perception.nn.nms import surviving
from avsec_gym.perception.nn.region_counts import ProposalCount


@dataclass(frozen=True, eq=False)
class PairProposals:
    """N pairs of regions of each of B images, best first, filled up with zeros.

    Args:
        left: x1, y1, x2, y2, pixels, shape (B, N, 4).
        right: The same rows of the right image, shape (B, N, 4).
        scores: The scores, shape (B, N).
        valid: Whether it is a region or filling, shape (B, N).
    """

    left: Tensor
    right: Tensor
    scores: Tensor
    valid: Tensor


@torch.no_grad()
def propose(
    output: StereoRpnOutput,
    count: ProposalCount,
    overlap: float,
    *,
    exact: bool = False,
    least_side: float = 0.0,
) -> PairProposals:
    """The best pairs that survive suppression in both views; no gradient passes.

    Args:
        output: The output of the stereo proposal network.
        count: Pairs before and after suppression.
        overlap: The overlap above which a worse region is suppressed.
        exact: Whether boxes are decoded exactly, see `decode_stereo`.
        least_side: Pairs with a lower or narrower box are dropped, pixels.
    """
    pairs, classes = len(output.scores), output.scores
    left = output.deltas.new_zeros(pairs, count.after, 4)
    right = torch.zeros_like(left)
    scores = classes.new_zeros(pairs, count.after)
    valid = torch.zeros_like(scores, dtype=torch.bool)
    for pair in range(pairs):
        order = torch.argsort(classes[pair], descending=True, stable=True)[: count.before]
        anchors = output.anchors[order]
        both = decode_stereo(anchors, anchors, output.deltas[pair, order], exact=exact)
        both_left, both_right = (clip_boxes(boxes, output.height, output.width) for boxes in both)
        if least_side:
            large = shorter_side(both_left).minimum(shorter_side(both_right)) >= least_side
            order, both_left, both_right = order[large], both_left[large], both_right[large]
        kept = surviving(both_left, overlap) & surviving(both_right, overlap)
        kept = kept.nonzero()[: count.after, 0]
        left[pair, : len(kept)] = both_left[kept]
        right[pair, : len(kept)] = both_right[kept]
        scores[pair, : len(kept)] = classes[pair, order[kept]]
        valid[pair, : len(kept)] = True
    return PairProposals(left, right, scores, valid)


def decode_stereo(
    left: Tensor, right: Tensor, deltas: Tensor, *, exact: bool = False
) -> tuple[Tensor, Tensor]:
    """The boxes that deltas mean: rows of the right box are moved as those of the left one.

    Args:
        left: Anchors or regions of the left image, shape (..., 4).
        right: The same of the right image, shape (..., 4).
        deltas: dx, dy, dw, dh of the left box, dx, dw of the right one, shape (..., 6).
        exact: Whether `encode_stereo` is undone; the published code lets a box of w pixels end at
            x1 + w, so that it comes out a pixel wider and higher.

    Returns:
        Left and right boxes, shape (..., 4) each.
    """
    last = 1.0 if exact else 0.0
    right_deltas = deltas[..., [4, 1, 5, 3]]
    return decode_boxes(left, deltas[..., :4], last), decode_boxes(right, right_deltas, last)


def encode_stereo(left: Tensor, right: Tensor, true_left: Tensor, true_right: Tensor) -> Tensor:
    """The deltas that turn regions (..., 4) into true boxes (..., 4), shape (..., 6)."""
    in_right = encode_boxes(right, true_right)
    return torch.cat((encode_boxes(left, true_left), in_right[..., 0:1], in_right[..., 2:3]), -1)
