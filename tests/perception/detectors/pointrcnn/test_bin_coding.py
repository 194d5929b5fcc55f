"""The code for boxes, there and back, and by the published formulas."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor
from torch.nn import functional

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.pointrcnn.bin_coding import MEAN_SIZE, BinCoding

COARSE, FINE = BinCoding(), BinCoding(1.5, 0.5, 9, is_fine=True)


def told(coding: BinCoding, boxes: Tensor) -> Tensor:
    """Codes that say what they should."""
    true = coding.targets(boxes)

    def bins(right: Tensor, residual: Tensor, count: int) -> tuple[Tensor, Tensor]:
        one = functional.one_hot(right, count).to(boxes)
        return 5 * one, residual[:, None] * one + 0.7 * (1 - one)

    x, z = bins(true.x_bin, true.x, coding.bins), bins(true.z_bin, true.z, coding.bins)
    heading = bins(true.heading_bin, true.heading, coding.headings)
    parts = [x[0], z[0], x[1], z[1], true.y[:, None], *heading, true.size]
    return torch.cat(parts, 1)


def test_columns_are_the_published_ones() -> None:
    assert (COARSE.channels, FINE.channels) == (76, 46)
    values = torch.arange(76.0)[None]
    parts = COARSE.parts(values)
    assert [part[0, 0].item() for part in vars(parts).values()] == [0, 12, 24, 36, 48, 49, 61, 73]


@given(st.data())
def test_there_and_back(data: st.DataObject) -> None:
    for coding, place, turn in ((COARSE, 2.99, 3.14), (FINE, 1.49, 0.78)):
        numbers = [data.draw(st.floats(-place, place)) for _ in range(3)]
        sizes = [data.draw(st.floats(0.5, 9)) for _ in range(3)]
        heading = data.draw(st.floats(-turn, turn))
        box = torch.tensor([[*numbers, *sizes, heading]], dtype=torch.float64)
        back = coding.decode(told(coding, box))
        assert (back - box)[0, :6].abs().max() < 1e-5
        assert math.cos(back[0, 6].item() - heading) > 1 - 1e-10


def test_single_precision_loses_less_than_a_hundredth_of_a_millimetre() -> None:
    randomness = np.random.default_rng(0)
    boxes = randomness.uniform([*[-2.9] * 3, 1, 1, 3, -3.1], [*[2.9] * 3, 2, 2, 5, 3.1], (500, 7))
    given = torch.from_numpy(boxes).float()
    assert (COARSE.decode(told(COARSE, given)) - given).abs().max() < 1e-5


def test_by_the_published_formulas() -> None:
    values = torch.randn(50, 76, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    for row, found in zip(values.tolist(), COARSE.decode(values).tolist(), strict=True):
        x_bin, z_bin = np.argmax(row[:12]), np.argmax(row[12:24])
        yaw_bin = int(np.argmax(row[49:61]))
        step = 2 * math.pi / 12
        yaw = yaw_bin * step + row[61 + yaw_bin] * step / 2
        expected = [
            x_bin * 0.5 + 0.25 - 3 + row[24 + x_bin] * 0.5,
            row[48],
            z_bin * 0.5 + 0.25 - 3 + row[36 + z_bin] * 0.5,
            *(row[73 + i] * MEAN_SIZE[i] + MEAN_SIZE[i] for i in range(3)),
        ]
        assert found[:6] == pytest.approx(expected)
        assert math.cos(found[6] - yaw) == pytest.approx(1)
        assert -math.pi <= found[6] <= math.pi


def test_a_fine_code_takes_front_for_back() -> None:
    """Whether a car is seen from behind is told by the proposal alone."""
    boxes = torch.zeros(4, 7)
    boxes[:, 6] = torch.tensor([0.3, 0.3 + np.pi, 0.3 - np.pi, -0.5])
    headings = FINE.decode(told(FINE, boxes))[:, 6]
    assert headings.tolist() == pytest.approx([0.3, 0.3, 0.3, -0.5], abs=1e-6)


def test_beyond_the_scope_is_its_border() -> None:
    boxes = torch.tensor([[7.0, 0, -7, 1.5, 1.6, 3.9, 0]])
    back = COARSE.decode(told(COARSE, boxes))
    assert back[0, [0, 2]].tolist() == pytest.approx([3, -3], abs=2e-3)


def test_bins_must_fill_the_scope() -> None:
    with pytest.raises(ConfigurationError, match=r"bins of 0\.7 m"):
        BinCoding(3.0, 0.7)
    with pytest.raises(ConfigurationError, match="0 headings"):
        BinCoding(headings=0)
