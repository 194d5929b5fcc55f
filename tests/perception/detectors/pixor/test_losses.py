"""The loss against sums by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration
from avsec_gym.perception.detectors.pixor.losses import pixor_losses
from avsec_gym.perception.detectors.pixor.network import PixorOutput
from avsec_gym.perception.detectors.pixor.targets import cell_targets

CAR = np.array([[4.0, 1.0, 4.0, 1.7, 0.3]])


def output_of(configuration: PixorConfiguration, seed: int = 0) -> PixorOutput:
    generator = torch.Generator().manual_seed(seed)
    shape = configuration.output_shape
    logits = torch.randn(1, *shape, generator=generator, requires_grad=True)
    values = torch.randn(1, 6, *shape, generator=generator, requires_grad=True)
    in_view = torch.ones(shape, dtype=torch.bool)
    in_view[:5] = False
    return PixorOutput(logits, values, in_view)


@pytest.mark.parametrize("focus", [0.0, 2.0])
def test_as_by_loops_over_cells(tiny: PixorConfiguration, focus: float) -> None:
    configuration = replace(tiny, focus=focus)
    output = output_of(configuration)
    targets = cell_targets(CAR, configuration, azimuths=(-0.7, 0.7))
    terms = pixor_losses(output, targets, configuration)
    entropy = focal = distance = cells = 0.0
    for row in range(48):
        for column in range(56):
            if not (targets.judged[0, row, column] and output.in_view[row, column]):
                continue
            p = 1 / (1 + math.exp(-output.logits[0, row, column].item()))
            is_car = bool(targets.positive[0, row, column])
            right = p if is_car else 1 - p
            entropy -= math.log(right)
            focal -= (0.25 if is_car else 0.75) * (1 - right) ** 2 * math.log(right)
            if is_car:
                cells += 1
                for i in range(6):
                    error = abs(
                        (
                            output.values[0, i, row, column] - targets.values[0, i, row, column]
                        ).item()
                    )
                    distance += error**2 / 2 if error < 1 else error - 0.5
    expected = focal / cells if focus else entropy / (48 * 56)
    assert terms["classification"].item() == pytest.approx(expected, rel=1e-5)
    assert terms["box"].item() == pytest.approx(tiny.box_weight * distance / cells, rel=1e-5)


def test_what_is_not_judged_gets_no_gradient(tiny: PixorConfiguration) -> None:
    output = output_of(tiny)
    targets = cell_targets(CAR, tiny, azimuths=(-0.2, 0.7))
    sum(pixor_losses(output, targets, tiny).values()).backward()
    assert output.logits.grad is not None
    counts = targets.judged & output.in_view
    assert ((output.logits.grad != 0) == counts).all()


def test_without_any_car_there_is_only_classification(tiny: PixorConfiguration) -> None:
    output = output_of(tiny)
    terms = pixor_losses(output, cell_targets(CAR[:0], tiny), tiny)
    assert terms["box"].item() == 0
    sum(terms.values()).backward()
    assert torch.isfinite(output.logits.grad).all()
