"""Boxes of anchors: those asked for are those of the whole field, and turned no farther."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from avsec_gym.geometry import wrap_angle
from avsec_gym.perception.detectors.dsgn.anchors import boxes_of_corners
from avsec_gym.perception.detectors.dsgn.box_field import BoxField
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.grid import CAR, CYCLIST


@pytest.mark.parametrize(("angles", "half_turns"), [(4, False), (2, True), (3, True)])
def test_some_are_as_among_all(tiny: DsgnConfiguration, angles: int, half_turns: bool) -> None:
    tiny = replace(tiny, angles=angles, half_turns=half_turns, anchors=(CAR, CYCLIST))
    generator = torch.Generator().manual_seed(0)
    regressed = torch.randn(2, 2, 6 + angles, 5, 7, generator=generator, dtype=torch.float64)
    field = BoxField(regressed, tiny)
    every = field.everywhere()
    assert every.shape == (2, angles, 2, 8, 3, 5, 7)
    limits = torch.tensor([2, angles, 2, 5, 7])
    index = tuple((torch.rand(40, 5, generator=generator) * limits).long().T)
    image, angle, kind, row, column = index
    some = field.at((image, angle, kind, row, column))
    torch.testing.assert_close(some, every[image, angle, kind, :, :, row, column])
    # No box leaves its anchor's share of the circle.
    _, _, yaw = boxes_of_corners(some.numpy())
    share = (np.pi if half_turns else 2 * np.pi) / angles
    assert (np.abs(wrap_angle(yaw - share * angle.numpy())) <= share / 2 + 1e-9).all()


def test_halves_become_singles(tiny: DsgnConfiguration) -> None:
    regressed = torch.zeros(1, 1, 10, 2, 2, dtype=torch.bfloat16)
    zero = torch.zeros(1, dtype=torch.int64)
    corners = BoxField(regressed, tiny).at((zero, zero, zero, zero, zero))
    assert corners.dtype == torch.float32
    assert corners[0, 0].tolist() == pytest.approx([1.95, 0.78, 0.8])
