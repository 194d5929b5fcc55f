"""The terms of the loss against numbers worked out by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.losses import (
    box_loss,
    centerness_loss,
    detection_losses,
    focal_loss,
    reversal_loss,
)
from avsec_gym.perception.detectors.dsgn.network import DsgnOutput
from avsec_gym.perception.detectors.dsgn.targets import anchor_targets
from tests.perception.detectors.dsgn.given_boxes import GivenBoxes


def test_focal_loss_of_a_found_and_of_a_false_one() -> None:
    logits = torch.tensor([0.0, math.log(9.0)], dtype=torch.float64)
    # p = 1/2 and 9/10; found: 1/4 (1 - p)^2 (-log p); false: 3/4 p^2 (-log(1 - p)).
    found = 0.25 * 0.25 * math.log(2), 0.25 * 0.01 * math.log(10 / 9)
    false = 0.75 * 0.25 * math.log(2), 0.75 * 0.81 * math.log(10)
    assert focal_loss(logits, torch.ones(2)).item() == pytest.approx(sum(found), rel=1e-5)
    assert focal_loss(logits, torch.zeros(2)).item() == pytest.approx(sum(false), rel=1e-5)
    mixed = focal_loss(logits, torch.tensor([1.0, 0.0])).item()
    assert mixed == pytest.approx(found[0] + false[1], rel=1e-5)


def test_focal_loss_stays_finite_where_the_network_is_surely_wrong() -> None:
    logits = torch.tensor([200.0, -200.0], requires_grad=True)
    loss = focal_loss(logits, torch.tensor([0.0, 1.0]))
    loss.backward()
    assert torch.isfinite(loss)
    assert torch.isfinite(logits.grad).all()


def test_box_loss_is_quadratic_below_a_ninth_and_weighted() -> None:
    true = torch.zeros(2, 8, 3, dtype=torch.float64)
    predicted = true.clone()
    predicted[0, 0, 0] = 0.06  # 0.5 * 0.06^2 * 9
    predicted[1, 3, 1] = 2.0  # 2 - 1/18
    one, two = 0.0162 / 24, (2 - 1 / 18) / 24
    loss = box_loss(predicted, true, torch.tensor([1.0, 0.25], dtype=torch.float64))
    assert loss.item() == pytest.approx((one + 0.25 * two) / 1.25)


def test_the_last_component_is_mixed_by_half_angles() -> None:
    true = torch.zeros(1, 8, 3, dtype=torch.float64)
    predicted = true.clone()
    true[0, 7, 2], predicted[0, 7, 2] = 1.3, 0.4
    apart = abs(math.sin(0.65) * math.cos(0.2) - math.cos(0.65) * math.sin(0.2))
    loss = box_loss(predicted, true, torch.ones(1, dtype=torch.float64))
    assert loss.item() == pytest.approx((apart - 1 / 18) / 24)


def test_centerness_is_a_mean_of_cross_entropies() -> None:
    logits, true = torch.zeros(4), torch.tensor([0.0, 0.3, 0.8, 1.0])
    assert centerness_loss(logits, true).item() == pytest.approx(math.log(2))


def _output(configuration: DsgnConfiguration, count: int = 2) -> DsgnOutput:
    generator = torch.Generator().manual_seed(0)
    angles, kinds = configuration.angles, len(configuration.anchors)
    cells = configuration.grid.z.cells, configuration.grid.x.cells

    def draw(*shape: int) -> torch.Tensor:
        return torch.randn(*shape, generator=generator, dtype=torch.float64, requires_grad=True)

    return DsgnOutput(
        draw(count, 4, 4),
        draw(count, 3, 4, 4),
        torch.arange(3.0),
        draw(count, angles, kinds, *cells),
        GivenBoxes(draw(count, angles, kinds, 8, 3, *cells)),
        draw(count, angles, *cells),
        draw(count, angles, kinds, *cells) if configuration.half_turns else None,
    )


def test_terms_pick_each_anchor_s_own_numbers(tiny: DsgnConfiguration) -> None:
    boxes = Boxes3D(
        np.array([[1.0, 1.6, 12.0], [-3.0, 1.7, 18.0]]),
        np.array([[1.5, 1.6, 4.0]] * 2),
        np.array([1.5, 0.2]),
        np.ones(2),
        np.array(["Car", "Van"]),
    )
    output = _output(tiny)
    targets = anchor_targets([boxes[:1], boxes], tiny)
    terms = detection_losses(output, targets)
    weighted, weights, entropies, wanted = 0.0, 0.0, [], torch.zeros(output.class_logits.shape)
    for i, (b, a, k, z, x) in enumerate(torch.stack(targets.index, 1).tolist()):
        centerness = targets.centerness[i]
        one = box_loss(
            output.corners[b, a, k, :, :, z, x][None], targets.corners[i : i + 1], centerness[None]
        )
        weighted, weights = weighted + (one * centerness).item(), weights + centerness.item()
        p = torch.sigmoid(output.centerness[b, a, z, x])
        entropies.append((-(centerness * p.log() + (1 - centerness) * (1 - p).log())).item())
        wanted[b, a, k, z, x] = 1
    assert terms["box"].item() == pytest.approx(weighted / weights)
    assert terms["centerness"].item() == pytest.approx(np.mean(entropies))
    focal = focal_loss(output.class_logits, wanted).item()
    assert terms["classification"].item() == pytest.approx(focal / (len(entropies) + 10))


def test_a_scene_without_objects_teaches_only_background(tiny: DsgnConfiguration) -> None:
    output = _output(tiny, 1)
    terms = detection_losses(output, anchor_targets([Boxes3D.empty()], tiny))
    assert terms["box"].item() == 0
    assert terms["centerness"].item() == 0
    sum(terms.values()).backward()
    assert (output.class_logits.grad > 0).all()


def test_reversal_is_a_weighted_mean_of_cross_entropies() -> None:
    logits, reverse = torch.tensor([0.0, math.log(3.0)]), torch.tensor([1.0, 0.0])
    loss = reversal_loss(logits, reverse, torch.tensor([1.0, 0.5]))
    assert loss.item() == pytest.approx((math.log(2) + 0.5 * math.log(4)) / 1.5)
    assert reversal_loss(logits[:0], reverse[:0], reverse[:0]).item() == 0


def test_with_half_turns_each_anchor_learns_which_way_its_box_heads(
    tiny: DsgnConfiguration,
) -> None:
    tiny = replace(tiny, half_turns=True, angles=2)
    car = Boxes3D(
        np.array([[1.0, 1.6, 12.0]]), np.array([[1.5, 1.6, 4.0]]), np.array([np.pi - 0.1]),
        np.ones(1), np.array(["Car"]),
    )  # fmt: skip
    output = _output(tiny, 1)
    targets = anchor_targets([car], tiny)
    assert (targets.index[1] == 0).all()
    assert (targets.reversed == 1).all()
    detection_losses(output, targets)["reversal"].backward()
    assert (output.reversal.grad != 0).sum() == len(targets.reversed)
    assert (output.reversal.grad <= 0).all()
