"""Boxes from a network's output: what was encoded comes back, once each."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import box_corners, project, wrap_angle
from avsec_gym.perception.detectors.dsgn.anchors import anchor_footprints
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.decoding import decode
from avsec_gym.perception.detectors.dsgn.decoding_rule import DsgnDecodingRule
from avsec_gym.perception.detectors.dsgn.grid import CAR, CYCLIST, PEDESTRIAN
from avsec_gym.perception.detectors.dsgn.network import DsgnOutput
from avsec_gym.perception.detectors.dsgn.targets import anchor_targets
from tests.perception.detectors.dsgn.given_boxes import GivenBoxes

PROJECTION = np.array([[700.0, 0, 600, 45], [0, 700, 170, 0.2], [0, 0, 1, 0.003]])[None]
SIZE = (370, 1220)
TRUTH = Boxes3D(
    np.array([[1.2, 1.6, 8.0], [-3.3, 1.7, 18.1], [4.0, 1.65, 21.0], [-1.0, 1.6, 12.0]]),
    np.array([[1.5, 1.6, 4.1], [1.9, 1.8, 4.4], [1.75, 0.65, 0.8], [1.7, 0.6, 1.8]]),
    np.array([1.5, -0.3, 2.0, -1.9]),
    np.ones(4),
    np.array(["Car", "Car", "Pedestrian", "Cyclist"]),
)


def _output(configuration: DsgnConfiguration, truth: Boxes3D) -> DsgnOutput:
    """What a perfect network says: at every positive anchor the object, elsewhere nothing."""
    targets = anchor_targets([truth], configuration, ("Pedestrian", "Car", "Cyclist"))
    angles, kinds = configuration.angles, len(configuration.anchors)
    cells = configuration.grid.z.cells, configuration.grid.x.cells
    logits = torch.full((1, angles, kinds, *cells), -9.0)
    corners = torch.zeros(1, angles, kinds, 8, 3, *cells)
    centerness = torch.full((1, angles, *cells), -9.0)
    image, angle, kind, row, column = targets.index
    logits[targets.index] = 2 * targets.centerness.float()
    corners[image, angle, kind, :, :, row, column] = targets.corners.float()
    centerness[image, angle, row, column] = torch.logit(targets.centerness.float(), 1e-3)
    reversal = None
    if configuration.half_turns:
        reversal = torch.zeros_like(logits)
        reversal[targets.index] = 8 * targets.reversed.float() - 4
    return DsgnOutput(
        torch.zeros(1, 2, 2),
        torch.zeros(1, 2, 2, 2),
        torch.ones(2),
        logits,
        GivenBoxes(corners),
        centerness,
        reversal,
    )


@pytest.fixture
def three_classes(tiny: DsgnConfiguration) -> DsgnConfiguration:
    return replace(tiny, anchors=(PEDESTRIAN, CAR, CYCLIST))


@pytest.mark.parametrize("half_turns", [False, True])
@pytest.mark.parametrize("changes", [{}, {"score_times_centerness": True}, {"voting_overlap": 0.3}])
def test_what_was_encoded_comes_back(
    three_classes: DsgnConfiguration, changes: dict[str, Any], half_turns: bool
) -> None:
    if half_turns:
        three_classes = replace(three_classes, half_turns=True, angles=2)
    rule = DsgnDecodingRule(**changes)
    [found] = decode(_output(three_classes, TRUTH), three_classes, PROJECTION, SIZE, rule)
    assert len(found) == len(TRUTH)
    assert (np.diff(found.score) <= 0).all()
    for i in range(len(TRUTH)):
        j = np.linalg.norm(found.location - TRUTH.location[i], axis=1).argmin()
        assert found.category[j] == TRUTH.category[i]
        np.testing.assert_allclose(found.location[j], TRUTH.location[i], atol=1e-5)
        np.testing.assert_allclose(found.dimensions[j], TRUTH.dimensions[i], atol=1e-5)
        assert abs(wrap_angle(found.rotation_y[j] - TRUTH.rotation_y[i])) < 1e-5
        x, _, z = TRUTH.location[i]
        assert found.alpha[j] == pytest.approx(TRUTH.rotation_y[i] - np.arctan2(x, z), abs=1e-5)
        pixels, _ = project(
            PROJECTION[0], box_corners(TRUTH.location[i], TRUTH.dimensions[i], TRUTH.rotation_y[i])
        )
        limits = np.array([SIZE[1] - 1, SIZE[0] - 1])
        expected = np.concatenate([pixels.min(0).clip(0, limits), pixels.max(0).clip(0, limits)])
        np.testing.assert_allclose(found.box2d[j], expected, atol=1e-2)


def test_nothing_sure_is_no_box(tiny: DsgnConfiguration) -> None:
    [found] = decode(_output(tiny, Boxes3D.empty()), tiny, PROJECTION, SIZE)
    assert len(found) == 0
    assert found.box2d is not None


def test_limits_keep_the_best(tiny: DsgnConfiguration) -> None:
    generator = torch.Generator().manual_seed(1)
    output = _output(tiny, Boxes3D.empty())
    logits = torch.randn(output.class_logits.shape, generator=generator)
    footprints = torch.from_numpy(anchor_footprints(tiny)).float()[0]
    corners = torch.zeros_like(output.corners)
    for level, y in ((0, 0.75), (4, -0.75)):
        for i in range(4):
            corners[0, :, 0, level + i, 0] = footprints[:, i, 0, None, None]
            corners[0, :, 0, level + i, 2] = footprints[:, i, 1, None, None]
            corners[0, :, 0, level + i, 1] = y
    output = replace(output, class_logits=logits, boxes=GivenBoxes(corners))
    [every] = decode(
        output, tiny, PROJECTION, SIZE, DsgnDecodingRule(candidates=9999, most_boxes=9999)
    )
    [some] = decode(output, tiny, PROJECTION, SIZE, DsgnDecodingRule(candidates=9999, most_boxes=7))
    assert len(every) > 30
    np.testing.assert_array_equal(some.score, every.score[:7])
    assert every.score[0] == pytest.approx(float(logits.max().sigmoid()))
    [few] = decode(output, tiny, PROJECTION, SIZE, DsgnDecodingRule(candidates=3))
    assert len(few) <= 3


def test_a_box_that_reaches_behind_the_camera_ends_at_the_border(
    tiny: DsgnConfiguration,
) -> None:
    beside = TRUTH[:1]
    beside = replace(
        beside, location=np.array([[-2.0, 1.6, 4.2]]), dimensions=beside.dimensions * 2.5
    )
    [found] = decode(_output(tiny, beside), tiny, PROJECTION, SIZE)
    left, _, right, bottom = found.box2d[0]
    assert left == 0
    assert bottom == SIZE[0] - 1
    assert left < right


def test_a_score_is_a_mean_of_class_and_fit(tiny: DsgnConfiguration) -> None:
    output = _output(tiny, TRUTH[:1])
    fit = torch.full_like(output.class_logits, 0.4)
    output = replace(output, fit=fit)
    [alone] = decode(output, tiny, PROJECTION, SIZE)
    [both] = decode(output, tiny, PROJECTION, SIZE, DsgnDecodingRule(fit_share=0.25))
    expected = alone.score**0.75 * torch.tensor(0.4).sigmoid().item() ** 0.25
    np.testing.assert_allclose(both.score, expected, rtol=1e-6)


def test_rules_check_themselves() -> None:
    wrong = ({"voting_overlap": 1.0}, {"voting_turn": 2.0}, {"fit_share": 1.1})
    for values in (*wrong, {"least_score": 0.0}, {"most_overlap": 1.2}, {"candidates": 0}):
        with pytest.raises(ConfigurationError):
            DsgnDecodingRule(**values)
