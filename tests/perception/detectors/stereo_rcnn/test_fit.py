"""A network that says what the targets ask for fits; whoever says another size fits less."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch.nn import functional

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.stereo_rcnn.fit import fit_loss, fit_targets
from avsec_gym.perception.detectors.stereo_rcnn.heads import KeypointOutput, PairBoxOutput
from avsec_gym.perception.detectors.stereo_rcnn.keypoints import stereo_truth
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera
from avsec_gym.perception.detectors.stereo_rcnn.targets import DIMENSION_DEVIATION, PairSamples
from avsec_gym.perception.nn.box_coding import encode_boxes

SIZE = (188, 621)
CAMERA = StereoCamera((360.0, 360.0), (310.0, 90.0), 0.54, (0.06, 0.0, 0.0), SIZE)
CARS = Boxes3D(
    [[-3.0, 1.6, 12], [2.0, 1.65, 16]],
    [[1.5, 1.6, 4.0], [1.4, 1.7, 4.2]],
    [-1.2, 0.7],
    np.ones(2),
    np.full(2, "Car"),
)
TRUTH = stereo_truth(CARS, CAMERA)


@pytest.fixture
def case():
    """Regions on both cars, their keypoints, and a third on the background."""
    left, right = (
        torch.tensor(np.vstack([boxes, [[10.0, 10, 60, 60]]]))[None]
        for boxes in (TRUTH.left, TRUTH.right)
    )
    width = (left[0, :2, 2] - left[0, :2, 0] + 1).numpy()[:, None]
    columns = np.hstack([TRUTH.keypoints, TRUTH.borders])
    cells = np.round((columns - TRUTH.left[:, :1]) * 28 / width)
    height, wide, length = TRUTH.dimensions.T
    sizes = np.column_stack([wide, height, length, np.sin(TRUTH.alpha), np.cos(TRUTH.alpha)])
    dimensions = torch.zeros(1, 3, 2, 5, dtype=torch.float64)
    dimensions[0, :2, 1] = torch.tensor((sizes - [1.6, 1.5, 4.0, 0, 0]) / DIMENSION_DEVIATION)
    corner = np.nanargmax(cells[:, :4], axis=1)
    places = np.column_stack([corner * 28 + cells[[0, 1], corner], cells[:, 4:].clip(0, 27)])
    targets = torch.full((1, 3, 3), -1)
    targets[0, :2] = torch.tensor(places).long()
    logits = torch.cat(
        [
            functional.one_hot(targets[0, :2, 0], 112).unflatten(1, (4, 28)),
            functional.one_hot(targets[0, :2, 1:], 28),
        ],
        1,
    )[None].double()
    boxes = PairBoxOutput(
        torch.zeros(1, 3, 2), torch.zeros(1, 3, 2, 6, dtype=torch.float64), dimensions
    )
    labels = torch.tensor([[1, 1, 0]])
    nothing = torch.zeros(0)
    # Exact boxes come out of decoding as they are, a pixel narrower than a delta of zero says.
    grown = torch.cat([left[..., :2], left[..., 2:] + 1], -1)
    grown_right = torch.cat([right[..., :2], right[..., 2:] + 1], -1)
    boxes.box_deltas[:, :, 1, :4] = encode_boxes(left, grown) / torch.tensor([0.1, 0.1, 0.2, 0.2])
    deltas = encode_boxes(right, grown_right)[..., [0, 2]]
    boxes.box_deltas[:, :, 1, 4:] = deltas / torch.tensor([0.1, 0.2])
    sampling = PairSamples(nothing, nothing, left, right, labels, nothing, nothing, targets)
    return boxes, KeypointOutput(logits), sampling


def fit(case):
    return fit_targets(*case, [TRUTH], [CAMERA], SIZE)[0].numpy()


def test_right_answers_fit(case):
    # A keypoint is known to a cell only.
    found = fit(case)
    assert (found[:2] > 0.85).all()
    assert found[2] == 0


def test_a_wrong_size_fits_less_and_a_wrong_place_not_at_all(case):
    boxes, keypoints, sampling = case
    exact = fit(case)
    # The first car's length: half a metre too long, where its visible faces are right.
    boxes.dimensions_orientation[0, 0, 1, 2] += 0.5 / DIMENSION_DEVIATION
    longer = fit(case)
    assert exact[0] - 0.25 < longer[0] < exact[0]
    assert longer[1] == pytest.approx(exact[1])
    # A box as wide as its car aside of it.
    boxes.box_deltas[0, 1, 1, [0, 4]] += 1.0 / 0.1
    assert fit((boxes, keypoints, sampling))[1] < 0.1


def test_objects_without_keypoints_teach_nothing(case):
    boxes, keypoints, sampling = case
    targets = sampling.keypoint_targets.clone()
    targets[0, 1] = -1
    found = fit((boxes, keypoints, replace(sampling, keypoint_targets=targets)))
    assert found[0] > 0.85
    assert np.isnan(found[1])
    logits = torch.tensor([[0.5, 2.0, -1.0]], dtype=torch.float64, requires_grad=True)
    loss = fit_loss(logits, torch.tensor(found)[None])
    expected = -found[0] * functional.logsigmoid(logits[0, 0])
    expected = expected - (1 - found[0]) * functional.logsigmoid(-logits[0, 0])
    expected = (expected - functional.logsigmoid(-logits[0, 2])) / 2
    torch.testing.assert_close(loss, expected)
    loss.backward()
    assert logits.grad[0, 1] == 0
