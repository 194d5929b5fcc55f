"""Fixtures for every test of perception."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor
from torch.nn import functional


@pytest.fixture
def smooth_activations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Softplus for every ReLU: networks without kinks, whose slopes finite differences tell.

    With ReLUs, whether one turns within a step depends on the last bits of the sums before it.
    """

    def softplus(inputs: Tensor, inplace: bool = False) -> Tensor:
        return functional.softplus(inputs)

    def leaky(inputs: Tensor, negative_slope: float = 0.01, inplace: bool = False) -> Tensor:
        return functional.softplus(inputs) + negative_slope * (inputs - functional.softplus(inputs))

    monkeypatch.setattr(torch.nn.functional, "relu", softplus)
    monkeypatch.setattr(torch.nn.functional, "leaky_relu", leaky)
