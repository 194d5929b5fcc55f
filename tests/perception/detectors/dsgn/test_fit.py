"""How well boxes fit: overlaps against those of their boxes, and a loss that reaches the head."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.fit import box_fit, fit_loss
from avsec_gym.perception.detectors.dsgn.network import DsgnOutput
from avsec_gym.perception.detectors.dsgn.targets import anchor_targets
from tests.perception.detectors.dsgn.given_boxes import GivenBoxes

CAR_HERE = Boxes3D(
    np.array([[1.0, 1.6, 12.0]]), np.array([[1.5, 1.6, 4.0]]), np.array([0.2]),
    np.ones(1), np.array(["Car"]),
)  # fmt: skip


@pytest.fixture
def output(tiny: DsgnConfiguration) -> DsgnOutput:
    """Every anchor that stands for the car says it exactly, the others say a point."""
    cells = tiny.grid.z.cells, tiny.grid.x.cells
    targets = anchor_targets([CAR_HERE, CAR_HERE[:0]], tiny)
    corners = torch.zeros(2, tiny.angles, 1, 8, 3, *cells, dtype=torch.float64)
    image, angle, kind, row, column = targets.index
    corners[image, angle, kind, :, :, row, column] = targets.corners
    logits = torch.linspace(-6, -4, corners[:, :, :, 0, 0].numel()).reshape(2, 4, 1, *cells)
    fit = torch.randn(logits.shape, generator=torch.Generator().manual_seed(0)).requires_grad_()
    return DsgnOutput(
        torch.zeros(2, 2, 2), torch.zeros(2, 2, 2, 2), torch.ones(2), logits,
        GivenBoxes(corners), torch.zeros(2, 4, *cells), None, fit,
    )  # fmt: skip


def _fit_at_targets(output: DsgnOutput, tiny: DsgnConfiguration, boxes: Boxes3D) -> Tensor:
    targets = anchor_targets([CAR_HERE, CAR_HERE[:0]], tiny)
    return box_fit(output, targets.index, [boxes, boxes[:0]], tiny, ("Car",))


def test_fit_is_the_overlap_in_space(output: DsgnOutput, tiny: DsgnConfiguration) -> None:
    np.testing.assert_allclose(_fit_at_targets(output, tiny, CAR_HERE), 1.0, atol=1e-6)
    # Half a metre higher, a third of the height: (1.5 - 0.5) / (1.5 + 0.5).
    higher = replace(CAR_HERE, location=CAR_HERE.location - [0, 0.5, 0])
    np.testing.assert_allclose(_fit_at_targets(output, tiny, higher), 0.5, atol=1e-6)
    cyclist = replace(CAR_HERE, category=np.array(["Cyclist"]))
    assert (_fit_at_targets(output, tiny, cyclist) == 0).all()


def test_likely_anchors_learn_beside_those_of_objects(
    output: DsgnOutput, tiny: DsgnConfiguration
) -> None:
    truth = [CAR_HERE, CAR_HERE[:0]]
    targets = anchor_targets(truth, tiny)
    loss = fit_loss(output, truth, targets, tiny, ("Car",))
    loss.backward()
    assert output.fit is not None
    learning = output.fit.grad != 0
    assert learning[targets.index].all()
    assert learning[1].sum() == 64
    assert learning[1].flatten()[-64:].all()  # Their logits rise to the end.
    wanted = torch.zeros_like(output.fit)
    wanted[targets.index] = 1.0
    expected = functional.binary_cross_entropy_with_logits(output.fit[learning], wanted[learning])
    assert loss.item() == pytest.approx(expected.item())
