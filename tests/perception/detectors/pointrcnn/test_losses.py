"""The loss against sums by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.perception.detectors.pointrcnn.bin_coding import MEAN_SIZE, BinCoding
from avsec_gym.perception.detectors.pointrcnn.configuration import PointRcnnConfiguration
from avsec_gym.perception.detectors.pointrcnn.losses import (
    box_losses,
    pointrcnn_losses,
    proposal_losses,
    refinement_losses,
)
from avsec_gym.perception.detectors.pointrcnn.network import PointRcnnNetwork
from avsec_gym.perception.detectors.pointrcnn.proposal_network import PointOutput
from avsec_gym.perception.detectors.pointrcnn.refinement_network import RefinementOutput
from avsec_gym.perception.detectors.pointrcnn.targets import PointTargets, RegionTargets

MakeScene = Callable[[int], Any]


def random(*shape: int) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(0), dtype=torch.float64)


def smooth(error: float) -> float:
    return error**2 / 2 if abs(error) < 1 else abs(error) - 0.5


def surprise(logits: list[float], right: int) -> float:
    return math.log(sum(math.exp(value) for value in logits)) - logits[right]


def test_boxes_as_by_loops() -> None:
    coding, codes = BinCoding(), random(20, 76)
    boxes = torch.from_numpy(
        np.random.default_rng(0).uniform([*[-3] * 3, 1, 1, 3, -3], [*[3] * 3, 2, 2, 5, 3], (20, 7))
    )
    place = heading = size = 0.0
    step = 2 * math.pi / 12
    for code, (x, y, z, *sizes, yaw) in zip(codes.tolist(), boxes.tolist(), strict=True):
        for value, first, residuals in ((x, 0, 24), (z, 12, 36)):
            right = math.floor((value + 3) / 0.5)
            place += surprise(code[first : first + 12], right)
            place += smooth(code[residuals + right] - ((value + 3) / 0.5 - right - 0.5))
        place += smooth(code[48] - y)
        turned = (yaw + step / 2) % (2 * math.pi)
        right = math.floor(turned / step)
        heading += surprise(code[49:61], right)
        heading += smooth(code[61 + right] - (turned - (right + 0.5) * step) / (step / 2))
        for told, true, mean in zip(code[73:], sizes, MEAN_SIZE, strict=True):
            size += smooth(told - (true - mean) / mean)
    terms = box_losses(codes, boxes, coding)
    assert terms["place"].item() == pytest.approx(place / 20)
    assert terms["heading"].item() == pytest.approx(heading / 20)
    assert terms["size"].item() == pytest.approx(3 * size / 60)


def test_segmentation_is_the_focal_loss_over_points_on_objects() -> None:
    logits = random(1, 30).requires_grad_()
    labels = torch.tensor([1] * 5 + [0] * 20 + [-1] * 5)
    output = PointOutput(random(1, 30, 3), random(1, 30, 4), logits, random(1, 30, 76))
    boxes = random(30, 7)
    terms = proposal_losses(output, [PointTargets(labels, boxes)], BinCoding())
    expected = 0.0
    for logit, label in zip(logits[0].tolist(), labels.tolist(), strict=True):
        p = 1 / (1 + math.exp(-logit))
        if label == 1:
            expected -= 0.25 * (1 - p) ** 2 * math.log(p)
        elif label == 0:
            expected -= 0.75 * p**2 * math.log(1 - p)
    assert terms["segmentation"].item() == pytest.approx(expected / 5, rel=1e-5)
    alone = box_losses(output.codes[0, :5].float(), boxes[:5], BinCoding())
    assert terms["proposal_place"].item() == pytest.approx(alone["place"].item())
    terms["segmentation"].backward()
    assert logits.grad is not None
    assert ((logits.grad[0] != 0) == (labels >= 0)).all()


def test_refinement_learns_from_what_is_sure_and_holds_points() -> None:
    coding = BinCoding(1.5, 0.5, 9, is_fine=True)
    output = RefinementOutput(random(6).requires_grad_(), random(6, 46).requires_grad_())
    labels = torch.tensor([1, 1, 0, 0, -1, 1])
    has_box = torch.tensor([True, True, False, False, True, True])
    targets = RegionTargets(random(6, 7), labels, has_box, random(6, 7))
    is_empty = torch.tensor([False] * 5 + [True])
    terms = refinement_losses(output, targets, is_empty, coding)
    chances = torch.sigmoid(output.logits).tolist()
    expected = -sum(
        math.log(p if y else 1 - p) for p, y in zip(chances, [1, 1, 0, 0], strict=False)
    )
    assert terms["confidence"].item() == pytest.approx(expected / 4, rel=1e-5)
    sum(terms.values()).backward()
    assert output.codes.grad is not None
    learned = output.codes.grad.abs().sum(1) > 0
    assert learned.tolist() == [True, True, False, False, True, False]


@pytest.mark.parametrize("cars", [3, 0])
def test_all_terms_are_finite_and_reach_every_weight(
    tiny: PointRcnnConfiguration, scene: MakeScene, cars: int
) -> None:
    torch.manual_seed(0)
    network = PointRcnnNetwork(tiny).train()
    points = torch.rand(2, 512, 3) * torch.tensor([16, 3, 20.0]) - torch.tensor([8, 1, 0])
    objects = torch.from_numpy(scene(0).rows[:cars]).float()
    terms = pointrcnn_losses(network, points, [objects, objects[:0]])
    assert list(terms) == [
        "segmentation",
        "proposal_place",
        "proposal_heading",
        "proposal_size",
        "confidence",
        "refined_place",
        "refined_heading",
        "refined_size",
    ]
    sum(terms.values()).backward()
    for name, value in network.named_parameters():
        assert value.grad is not None, name
        assert torch.isfinite(value.grad).all(), name
    if not cars:
        assert terms["proposal_place"] == terms["refined_size"] == 0
