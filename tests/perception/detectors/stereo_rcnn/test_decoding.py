"""A network that says exactly what the targets ask for must give the labelled boxes back."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch.nn import functional

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import wrap_angle
from avsec_gym.perception.detectors.stereo_rcnn.alignment import Alignment
from avsec_gym.perception.detectors.stereo_rcnn.decoding import (
    EVIDENCE,
    keypoint_certainty,
    observed_boxes,
    select,
    solved_boxes,
)
from avsec_gym.perception.detectors.stereo_rcnn.decoding_rule import StereoRcnnDecodingRule
from avsec_gym.perception.detectors.stereo_rcnn.heads import KeypointOutput, PairBoxOutput
from avsec_gym.perception.detectors.stereo_rcnn.keypoints import stereo_truth
from avsec_gym.perception.detectors.stereo_rcnn.proposals import PairProposals
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera
from avsec_gym.perception.detectors.stereo_rcnn.stereo_rpn import StereoRpnOutput
from avsec_gym.perception.detectors.stereo_rcnn.targets import draw_sampling
from avsec_gym.perception.nn.region_counts import SampleCount

LEFT = np.array([[720.0, 0, 620, 45], [0, 720, 180, 0.2], [0, 0, 1, 0.003]])
RIGHT = np.array([[720.0, 0, 620, -340], [0, 720, 180, 0.2], [0, 0, 1, 0.003]])
CAMERA = StereoCamera.of_projections(LEFT, RIGHT, (375, 1242))
SIZE = (192, 640)
STAY = Alignment(coarse_steps=1, fine_steps=1, disparity_offset=0)
BLACK = np.zeros((375, 1242, 3), np.float32)
LABELS = Boxes3D(
    [[-4.0, 1.6, 14], [3, 1.65, 22], [0.5, 1.7, 9], [7, 1.6, 30]],
    [[1.5, 1.6, 4.0], [1.4, 1.7, 4.2], [1.6, 1.7, 3.8], [1.5, 1.6, 4.1]],
    [-1.2, 0.4, 1.9, -2.6],
    np.ones(4),
    np.full(4, "Car"),
)


@pytest.fixture(scope="module")
def perfect():
    """Proposals beside the cars (some twice, some empty) and the heads' perfect answers."""
    scale = SIZE[0] / 375, SIZE[1] / 1242
    truth = stereo_truth(LABELS, CAMERA).resized(*scale)
    shifts = np.array([[1.0, -1, 2, 1], [-2, 1, -1, 0]])
    left, right = (
        torch.from_numpy((view[:, None] + shifts).reshape(1, -1, 4))
        for view in (truth.left, truth.right)
    )
    empty = torch.tensor([[[10.0, 5, 60, 40]]], dtype=torch.float64)
    left, right = torch.cat([left, empty], 1), torch.cat([right, empty], 1)
    scores = torch.ones(1, 9, dtype=torch.float64)
    proposals = PairProposals(left, right, scores, scores > 0)
    nothing = torch.zeros(1, 1, 6, dtype=torch.float64)
    rpn = StereoRpnOutput(nothing[..., :2], nothing[..., 0], nothing, nothing[0, :, :4], *SIZE)
    generator = torch.Generator().manual_seed(0)
    sampling = draw_sampling(rpn, proposals, [truth], SampleCount(1, 0, 60, 1.0), generator)
    said = PairProposals(
        sampling.left,
        sampling.right,
        scores.new_ones(1, 60),
        torch.ones(1, 60, dtype=torch.bool),
    )
    certainty = torch.linspace(3, 5, 60, dtype=torch.float64) * (2 * sampling.labels - 1)
    boxes = PairBoxOutput(
        torch.stack([-certainty, certainty], -1),
        sampling.box_targets[:, :, None].expand(-1, -1, 2, -1),
        sampling.dimension_targets[:, :, None].expand(-1, -1, 2, -1),
    )

    def keypoints(regions):
        places = [sampling.left[0].tolist().index(region) for region in regions.tolist()]
        cells = sampling.keypoint_targets[0, places].clamp(min=0)
        corner = functional.one_hot(cells[:, 0], 112).unflatten(1, (4, 28))
        borders = functional.one_hot(cells[:, 1:], 28)
        return KeypointOutput(torch.cat([corner, borders], 1)[None].double())

    return said, boxes, keypoints


def test_perfect_answers_give_the_labels_back(perfect):
    proposals, boxes, keypoints = perfect
    selected = select(proposals, boxes, SIZE, StereoRcnnDecodingRule())[0]
    assert len(selected.scores) == 4
    assert (selected.scores.diff() <= 0).all()
    observed = observed_boxes(selected, keypoints(selected.regions), 0, SIZE, CAMERA)
    truth = stereo_truth(LABELS, CAMERA)
    known = keypoints(selected.regions)
    certainty = keypoint_certainty(known, 0, 4)
    for sure, logits in zip(certainty, known.corner_logits[0].numpy(), strict=True):
        assert sure == pytest.approx(float(np.exp(logits).max() / np.exp(logits).sum()))
    scores = selected.scores.numpy()
    evidenced = solved_boxes(observed, scores, certainty, ["Car"] * 4, (BLACK, BLACK), CAMERA, STAY)
    found, evidence = evidenced.boxes, dict(zip(EVIDENCE, evidenced.evidence.T, strict=True))
    # Two black images agree at any depth.
    np.testing.assert_array_equal(evidence["contrast"], 0.0)
    np.testing.assert_array_equal(evidence["keypoint"], certainty)
    for i in range(4):
        order = np.linalg.norm(found.location - LABELS.location[i], axis=1).argmin()
        np.testing.assert_allclose(found.box2d[order], truth.left[i], atol=1e-6)
        np.testing.assert_allclose(found.dimensions[order], LABELS.dimensions[i])
        # A keypoint is known to a cell, a twenty-eighth of the region.
        error = np.abs(found.location[order] - LABELS.location[i])
        assert (error < [0.1, 0.05, 0.03 * LABELS.location[i, 2]]).all()
        turned = abs(wrap_angle(found.rotation_y[order] - LABELS.rotation_y[i]))
        assert turned < 0.06
        x, _, z = found.location[order]
        assert found.alpha[order] == pytest.approx(
            wrap_angle(found.rotation_y[order] - np.arctan2(x, z))
        )


def test_unlikely_regions_are_dropped(perfect):
    proposals, boxes, _ = perfect
    selected = select(proposals, boxes, SIZE, StereoRcnnDecodingRule(least_score=0.99995))[0]
    assert len(selected.scores) < 4
    everything = select(proposals, boxes, SIZE, StereoRcnnDecodingRule(least_score=0, overlap=1.0))[
        0
    ]
    assert len(everything.scores) == 60


def test_a_score_has_a_share_of_the_fit(perfect):
    proposals, boxes, _ = perfect
    everything = StereoRcnnDecodingRule(least_score=0, overlap=1.0)
    plain = select(proposals, boxes, SIZE, everything)[0]
    boxes = replace(boxes, fit_logits=torch.linspace(-3, 3, 60, dtype=torch.float64)[None])
    assert torch.equal(select(proposals, boxes, SIZE, everything)[0].scores, plain.scores)
    shared = select(proposals, boxes, SIZE, replace(everything, fit_share=0.25))[0]
    likely = boxes.class_probabilities[0, :, 1]
    expected = likely**0.75 * boxes.fit_logits[0].sigmoid() ** 0.25
    torch.testing.assert_close(shared.scores, expected.sort(descending=True).values)


def test_a_rule_is_checked():
    with pytest.raises(ConfigurationError, match=r"0\.\.1"):
        StereoRcnnDecodingRule(overlap=2)
    with pytest.raises(ConfigurationError, match=r"0\.\.1"):
        StereoRcnnDecodingRule(fit_share=1.5)
