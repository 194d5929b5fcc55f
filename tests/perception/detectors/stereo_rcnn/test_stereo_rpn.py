"""The stereo proposal network: order of channels, both readings of scores."""

from __future__ import annotations

from dataclasses import replace

import torch

from avsec_gym.perception.detectors.stereo_rcnn.configuration import SMALL
from avsec_gym.perception.detectors.stereo_rcnn.stereo_rpn import StereoRpn, StereoRpnOutput
from avsec_gym.perception.nn.feature_pyramid import STRIDES, FeaturePyramid

SHAPES = [(6, 8), (3, 4), (2, 2), (1, 1), (1, 1)]


def _pyramid(seed: int) -> FeaturePyramid:
    generator = torch.Generator().manual_seed(seed)
    levels = tuple(torch.randn(2, 64, *shape, generator=generator) for shape in SHAPES)
    return FeaturePyramid(levels, 24, 32)


def _output(crossed: bool) -> tuple[StereoRpn, StereoRpnOutput]:
    torch.manual_seed(0)
    network = StereoRpn(replace(SMALL, crossed_scores=crossed))
    return network, network(_pyramid(1), _pyramid(2))


def test_the_order_of_outputs_is_that_of_anchors() -> None:
    """A bump at one cell of one level of the left view moves just the anchors around it."""
    network, before = _output(crossed=False)
    left = _pyramid(1)
    left.levels[1][0, :, 2, 3] += 10
    after = network(left, _pyramid(2))
    changed = (after.deltas != before.deltas).any(-1)
    assert not changed[1].any()
    centre = (before.anchors[:, :2] + before.anchors[:, 2:]) / 2
    expected = torch.zeros(len(centre), dtype=torch.bool)
    start = 3 * 6 * 8
    expected[start : start + 3 * 3 * 4] = True
    near = (centre - torch.tensor([3.0, 2.0]) * STRIDES[1]).abs().amax(1) <= STRIDES[1]
    assert torch.equal(changed[0], expected & near)


def test_scores_of_the_pairs_that_the_loss_trains() -> None:
    _, output = _output(crossed=False)
    torch.testing.assert_close(output.scores, output.logits.softmax(-1)[..., 1])


def test_scores_as_the_published_code_reads_them() -> None:
    """Softmax over the channels' two halves, thereof each pair's second: channels 1, 3, 5."""
    _, output = _output(crossed=True)
    channels = output.logits.reshape(2, -1, 6)  # of each location
    for ratio, (channel, partner) in enumerate([(1, 4), (3, 0), (5, 2)]):
        probability = torch.sigmoid(channels[..., channel] - channels[..., partner])
        torch.testing.assert_close(output.scores.reshape(2, -1, 3)[..., ratio], probability)


def test_both_views_count() -> None:
    network, output = _output(crossed=False)
    swapped = network(_pyramid(2), _pyramid(1))
    assert not torch.allclose(output.deltas, swapped.deltas)
