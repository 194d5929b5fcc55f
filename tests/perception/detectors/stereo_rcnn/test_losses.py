"""Every term against plain loops over the elements."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch.nn import functional

from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.detectors.stereo_rcnn.heads import KeypointOutput, PairBoxOutput
from avsec_gym.perception.detectors.stereo_rcnn.losses import (
    FIT,
    TERMS,
    TermWeights,
    detection_terms,
    smooth_l1,
)
from avsec_gym.perception.detectors.stereo_rcnn.stereo_rpn import StereoRpnOutput
from avsec_gym.perception.detectors.stereo_rcnn.targets import PairSamples
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import save_weights

BATCH, ANCHORS, REGIONS = 2, 12, 6


@pytest.fixture
def case():
    generator = torch.Generator().manual_seed(0)

    def normal(*shape):
        return torch.randn(*shape, generator=generator, dtype=torch.float64)

    rpn = StereoRpnOutput(
        normal(BATCH, ANCHORS, 2),
        normal(BATCH, ANCHORS),
        normal(BATCH, ANCHORS, 6),
        normal(ANCHORS, 4),
        64,
        64,
    )
    boxes = PairBoxOutput(
        normal(BATCH, REGIONS, 2), normal(BATCH, REGIONS, 2, 6), normal(BATCH, REGIONS, 2, 5)
    )
    keypoints = KeypointOutput(normal(BATCH, REGIONS, 6, 28))
    labels = torch.tensor([[1, 0, 1, 0, 0, 0], [1, 0, 0, 0, 0, 0]])
    cells = torch.full((BATCH, REGIONS, 3), -1)
    cells[0, 0] = torch.tensor([60, 3, -1])
    cells[1, 0] = torch.tensor([111, -1, -1])
    on = (labels > 0)[..., None]
    sampling = PairSamples(
        torch.tensor([[1, 0, -1, 0] * 3, [-1, 1, 0, -1] * 3]),
        normal(BATCH, ANCHORS, 6),
        normal(BATCH, REGIONS, 4),
        normal(BATCH, REGIONS, 4),
        labels,
        normal(BATCH, REGIONS, 6) * on,
        normal(BATCH, REGIONS, 5) * on,
        cells,
    )
    return rpn, boxes, keypoints, sampling


def cross_entropy(logits, target):
    return math.log(sum(math.exp(float(x)) for x in logits)) - float(logits[target])


def robust(x, sigma):
    x = abs(float(x))
    return 0.5 * (sigma * x) ** 2 if x < 1 / sigma**2 else x - 0.5 / sigma**2


def test_terms_by_hand(case):
    rpn, boxes, keypoints, sampling = case
    terms = detection_terms(*case, sampling.keypoint_targets)
    assert tuple(terms) == TERMS
    every = [(b, a) for b in range(BATCH) for a in range(ANCHORS)]
    used = [at for at in every if sampling.anchor_labels[at] >= 0]
    expected = sum(cross_entropy(rpn.logits[at], sampling.anchor_labels[at]) for at in used)
    assert float(terms["rpn_class"]) == pytest.approx(expected / len(used))
    expected = sum(
        robust(x, 3) / 6
        for at in used
        if sampling.anchor_labels[at] == 1
        for x in rpn.deltas[at] - sampling.anchor_targets[at]
    )
    assert float(terms["rpn_box"]) == pytest.approx(expected / len(used))
    regions = [(b, r) for b in range(BATCH) for r in range(REGIONS)]
    expected = sum(cross_entropy(boxes.class_logits[at], sampling.labels[at]) for at in regions)
    assert float(terms["class"]) == pytest.approx(expected / len(regions))
    expected = sum(
        robust(x, 1)
        for at in regions
        if sampling.labels[at]
        for x in boxes.box_deltas[at][1] - sampling.box_targets[at]
    )
    assert float(terms["box"]) == pytest.approx(expected / len(regions))
    expected = sum(
        robust(x, 1)
        for at in regions
        for x in boxes.dimensions_orientation[at][sampling.labels[at]]
        - sampling.dimension_targets[at]
    )
    assert float(terms["dimensions"]) == pytest.approx(expected / len(regions))
    first, second = keypoints.logits[0, 0], keypoints.logits[1, 0]
    corner = (cross_entropy(first[:4].flatten(), 60) + cross_entropy(second[:4].flatten(), 111)) / 2
    expected = (corner + cross_entropy(first[4], 3) + 0) / 3
    assert float(terms["keypoints"]) == pytest.approx(expected)


def test_smooth_l1_is_torch_s_with_beta():
    x = torch.linspace(-2, 2, 41)
    for sharpness in (1.0, 3.0):
        theirs = functional.smooth_l1_loss(
            x, torch.zeros(41), beta=1 / sharpness**2, reduction="none"
        )
        torch.testing.assert_close(smooth_l1(x, sharpness), theirs)


def test_uncertainty_weighs_the_terms():
    weights = TermWeights()
    assert weights.log_variances.tolist() == [-1] * 6
    terms = dict(zip(TERMS, torch.arange(6.0), strict=True))
    weighted = weights(terms)
    for i, name in enumerate(TERMS):
        assert float(weighted[name].detach()) == pytest.approx(i * math.e - 1)
    sum(weighted.values()).backward()
    # Least where exp(s) is the term itself.
    expected = [1 - i * math.e for i in range(6)]
    assert weights.log_variances.grad.tolist() == pytest.approx(expected)


def test_the_fit_has_a_weight_of_its_own():
    assert TermWeights().fit_log_variance is None
    weights = TermWeights(fit=True)
    with torch.no_grad():
        weights.fit_log_variance[:] = 0.5
    weighted = weights({FIT: torch.tensor(2.0)})[FIT].detach()
    assert float(weighted) == pytest.approx(2 * math.exp(-0.5) + 0.5)


def test_regions_with_keypoints_come_first_and_keep_their_targets(case):
    sampling = case[3]
    cells = torch.full((BATCH, REGIONS, 3), -1)
    cells[0, 2], cells[0, 4], cells[1, 5] = (
        torch.tensor([7, 1, 2]),
        torch.tensor([-1, -1, 9]),
        torch.tensor([30, -1, -1]),
    )
    regions, targets = replace(sampling, keypoint_targets=cells).with_keypoints()
    assert torch.equal(regions[0], sampling.left[0, [2, 4]])
    assert torch.equal(targets[0], cells[0, [2, 4]])
    assert torch.equal(regions[1, 0], sampling.left[1, 5])
    assert (targets[1, 1] == -1).all()


def test_learned_weights_of_the_terms_come_with_the_card(tmp_path: Path) -> None:
    own = StereoRcnnDetector()
    path = tmp_path / "own.safetensors"
    logs = [-2.5, -2.0, -1.5, -1.25, -1.0, 0.25]
    beside = {
        "term_weights.log_variances": logs,
        "term_weights.fit_log_variance": [0.5],
    }
    save_weights(path, own.network, ModelCard("stereo_rcnn", beside=beside, storage="float32"))
    learned = StereoRcnnDetector(weights=path).term_weights
    assert learned.log_variances.tolist() == logs
    assert learned.fit_log_variance.tolist() == [0.5]
    assert own.term_weights.log_variances.tolist() == [-1.0] * 6


def test_without_sizes_of_the_background_only_objects_teach_them(case):
    boxes, sampling = case[1], case[3]
    terms = detection_terms(*case, sampling.keypoint_targets, background_sizes=False)
    regions = [(b, r) for b in range(BATCH) for r in range(REGIONS)]
    expected = sum(
        robust(x, 1)
        for at in regions
        if sampling.labels[at]
        for x in boxes.dimensions_orientation[at][1] - sampling.dimension_targets[at]
    )
    assert float(terms["dimensions"]) == pytest.approx(expected / len(regions))
    assert terms["dimensions"] < detection_terms(*case, sampling.keypoint_targets)["dimensions"]
