"""What becomes a detection."""

from __future__ import annotations

import pytest
import torch

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.box_selection import SelectionRule, select

BOXES = torch.tensor([[0.0, 0, 9, 9], [1, 0, 10, 9], [30, 0, 39, 9], [60, 0, 69, 9]])


def test_the_best_of_each_place_and_class_survive_in_order() -> None:
    scores = torch.tensor([[0.5, 0.1], [0.7, 0.6], [0.9, 0.0], [0.04, 0.04]])
    found = select(BOXES[:, None], scores, SelectionRule(least_score=0.05, overlap=0.5))
    assert found.scores.tolist() == pytest.approx([0.9, 0.7, 0.6])
    assert found.classes.tolist() == [0, 0, 1]
    assert torch.equal(found.boxes, BOXES[[2, 1, 1]])


def test_classes_may_have_boxes_of_their_own() -> None:
    boxes = torch.stack([BOXES, BOXES + 100], 1)
    found = select(boxes, torch.tensor([[0.5, 0.6]] + [[0.0, 0.0]] * 3), SelectionRule())
    assert torch.equal(found.boxes, torch.stack([BOXES[0] + 100, BOXES[0]]))


def test_nothing_likely_is_nothing_found() -> None:
    found = select(BOXES[:, None], torch.zeros(4, 2), SelectionRule())
    assert found.boxes.shape == (0, 4)


def test_impossible_rules_are_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"0\.\.1"):
        SelectionRule(overlap=1.5)
