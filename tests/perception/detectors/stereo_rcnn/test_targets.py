"""Targets of hand-placed objects, anchors and regions."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from avsec_gym.perception.detectors.stereo_rcnn.keypoints import StereoTruth
from avsec_gym.perception.detectors.stereo_rcnn.proposals import PairProposals, decode_stereo
from avsec_gym.perception.detectors.stereo_rcnn.stereo_rpn import StereoRpnOutput
from avsec_gym.perception.detectors.stereo_rcnn.targets import (
    BOX_DEVIATIONS,
    draw_sampling,
    keypoint_targets,
)
from avsec_gym.perception.nn.anchors import pyramid_anchors
from avsec_gym.perception.nn.box_coding import overlaps
from avsec_gym.perception.nn.feature_pyramid import STRIDES
from avsec_gym.perception.nn.region_counts import SampleCount

LEFT = np.array([[60.0, 30, 99, 59], [200, 40, 259, 89]])
RIGHT = np.array([[50.0, 30, 89, 59], [180, 40, 239, 89]])
KEYPOINTS = np.array([[np.nan, np.nan, np.nan, 80.0], [np.nan, 215.0, np.nan, np.nan]])
TRUTH = StereoTruth(
    LEFT,
    RIGHT,
    KEYPOINTS,
    LEFT[:, [0, 2]],
    np.array([[1.5, 1.6, 4.0], [1.4, 2.1, 3.0]]),
    np.array([0.3, -2.0]),
    np.array([1, 1]),
    np.zeros((2, 3)),
)
NOTHING = StereoTruth(
    *(np.zeros((0, n)) for n in (4, 4, 4, 2, 3)),
    np.zeros(0),
    np.zeros(0, np.intp),
    np.zeros((0, 3)),
)


def rpn_output(height=128, width=320):
    shapes = [(height // stride, width // stride) for stride in STRIDES]
    anchors = pyramid_anchors(shapes, STRIDES, (12, 24, 48, 96, 192), (0.5, 1.0, 2.0))
    count = len(anchors)
    zeros = torch.zeros(1, count, dtype=torch.float64)
    return StereoRpnOutput(
        zeros[..., None].expand(1, count, 2),
        zeros,
        zeros[..., None].expand(1, count, 6),
        anchors,
        height,
        width,
    )


def regions(*pairs):
    left, right = torch.tensor(pairs, dtype=torch.float64).unbind(1)
    scores = torch.ones(1, len(pairs), dtype=torch.float64)
    return PairProposals(left[None], right[None], scores, scores > 0)


ELSEWHERE = ([10.0, 80, 40, 120], [5.0, 80, 35, 120])
ON_FIRST = ([62.0, 31, 101, 60], [51.0, 31, 90, 60])
ONLY_LEFT = ([62.0, 31, 101, 60], [5.0, 31, 44, 60])
MIXED = ([62.0, 31, 101, 60], [181.0, 41, 240, 90])
PROPOSALS = regions(ELSEWHERE, ON_FIRST, ONLY_LEFT, MIXED)


def draw(truth=TRUTH, proposals=PROPOSALS, count=SampleCount(64, 0.5, 32, 0.25), seed=0):
    generator = torch.Generator().manual_seed(seed)
    return draw_sampling(rpn_output(), proposals, [truth], count, generator)


def test_anchors_on_the_union_box_are_objects_and_lead_to_both_boxes():
    sampling, anchors = draw(), rpn_output().anchors
    labels = sampling.anchor_labels[0]
    union = torch.from_numpy(TRUTH.union)
    best = overlaps(anchors, union).max(1)
    inside = (anchors >= 0).all(1) & (anchors[:, 2] < 320) & (anchors[:, 3] < 128)
    assert inside[labels >= 0].all()
    true = labels == 1
    tops = overlaps(anchors * inside[:, None], union).max(0).values
    assert all((best.values[i] >= 0.7) or (best.values[i] in tops) for i in true.nonzero()[:, 0])
    assert set(best.indices[true].tolist()) == {0, 1}
    assert (best.values[labels == 0] < 0.3).all()
    assert (labels >= 0).sum() == 64
    left, right = decode_stereo(anchors[true], anchors[true], sampling.anchor_targets[0, true])
    # As published, decoding ends one pixel beyond the last one.
    for decoded, boxes in ((left, LEFT), (right, RIGHT)):
        expected = torch.from_numpy(boxes)[best.indices[true]] + torch.tensor([0, 0, 1, 1])
        torch.testing.assert_close(decoded, expected)


def test_a_region_is_an_object_where_both_views_agree():
    sampling = draw()
    found = {
        (tuple(left), tuple(right)): label
        for left, right, label in zip(
            sampling.left[0].tolist(),
            sampling.right[0].tolist(),
            sampling.labels[0].tolist(),
            strict=True,
        )
    }
    assert found.pop((tuple(ON_FIRST[0]), tuple(ON_FIRST[1]))) == 1
    for i in range(2):
        assert found.pop((tuple(LEFT[i]), tuple(RIGHT[i]))) == 1
    assert found == {(tuple(left), tuple(right)): 0 for left, right in (ELSEWHERE, ONLY_LEFT)}
    assert sampling.labels.shape == (1, 32)


def test_targets_are_normalised():
    sampling = draw()
    row = sampling.left[0].tolist().index(ON_FIRST[0])
    assert sampling.labels[0, row] == 1
    # Both boxes must move by (-2, -1) of 40 x 30 px, the right one by -1 px.
    expected = [-2 / 40 / 0.1, -1 / 30 / 0.1, 0, 0, -1 / 40 / 0.1, 0]
    assert sampling.box_targets[0, row].tolist() == pytest.approx(expected)
    assert BOX_DEVIATIONS[2:4] == (0.2, 0.2)
    expected = [0, 0, 0, math.sin(0.3) / 0.5, math.cos(0.3) / 0.5]
    assert sampling.dimension_targets[0, row].tolist() == pytest.approx(expected)
    second = sampling.left[0].tolist().index(LEFT[1].tolist())
    assert sampling.dimension_targets[0, second, :3].tolist() == pytest.approx([1, -0.2, -2])
    background = sampling.labels[0] == 0
    assert not sampling.box_targets[0, background].any()
    assert not sampling.dimension_targets[0, background].any()
    assert (sampling.keypoint_targets[0, background] == -1).all()
    # 80 is 18 px right of 62, of 40 px in 28 cells: cell 12.6; the borders leave at cell -1.4.
    assert sampling.keypoint_targets[0, row].tolist() == [3 * 28 + 13, -1, 26]


def test_keypoint_cells():
    nowhere = float("nan")
    columns = torch.tensor([[nowhere, 120.0, nowhere, nowhere, 100.0, 154.0]])
    region = torch.tensor([[100.0, 0, 155, 40]])
    assert keypoint_targets(columns, region).tolist() == [[28 + 10, 0, 27]]
    outside = torch.tensor([[98.0, nowhere, nowhere, 156.0, 98.0, 160.0]])
    assert keypoint_targets(outside, region).tolist() == [[-1, -1, -1]]


def test_samples_are_seeded_and_bounded():
    one, again, other = draw(seed=1), draw(seed=1), draw(seed=2)
    assert torch.equal(one.anchor_labels, again.anchor_labels)
    assert not torch.equal(one.anchor_labels, other.anchor_labels)
    few = draw(count=SampleCount(4, 0.5, 8, 0.25))
    assert (few.anchor_labels == 1).sum() == 2
    assert (few.anchor_labels == 0).sum() == 2
    assert few.labels.sum() == 2


def test_an_empty_street_is_all_background():
    sampling = draw(NOTHING)
    assert (sampling.anchor_labels == 1).sum() == 0
    assert (sampling.anchor_labels == 0).sum() == 64
    assert not sampling.labels.any()


def test_objects_fill_the_sample_where_there_is_no_background():
    assert draw(proposals=regions(ON_FIRST)).labels.all()


def test_filling_is_no_region_and_classes_are_kept():
    padded = replace(PROPOSALS, valid=torch.tensor([[True, True, False, False]]))
    kept = {tuple(row) for row in draw(proposals=padded).right[0].tolist()}
    assert tuple(ONLY_LEFT[1]) not in kept
    sampling = draw(replace(TRUTH, classes=np.array([1, 2])))
    assert set(sampling.labels[0].tolist()) == {0, 1, 2}
