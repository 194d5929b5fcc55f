"""Weights of a relative: what has the same name and shape is taken, the rest stays."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch
from torch import nn

from avsec_gym.errors import DataError
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.partial import load_what_fits
from avsec_gym.perception.weights.store import save_weights


def _network(width: int, *, normalised: bool = True) -> nn.Sequential:
    middle = nn.BatchNorm2d(4) if normalised else nn.GroupNorm(2, 4)
    return nn.Sequential(nn.Conv2d(3, 4, 3), middle, nn.Conv2d(4, width, 1))


def _saved(network: nn.Module, folder: Path) -> Path:
    save_weights(folder / "w.safetensors", network, ModelCard("net", storage="float32"))
    return folder / "w.safetensors"


def test_all_of_the_same_network_fits_without_a_word(tmp_path: Path) -> None:
    one, other = _network(5), _network(5)
    card, report = load_what_fits(_saved(one, tmp_path), other)
    assert card is not None
    assert report == ""
    for name, value in one.state_dict().items():
        assert torch.equal(value, other.state_dict()[name])


def test_of_another_what_fits_is_taken_and_told(tmp_path: Path) -> None:
    one, other = _network(5), _network(7, normalised=False)
    before = {name: value.clone() for name, value in other.state_dict().items()}
    _, report = load_what_fits(_saved(one, tmp_path), other)
    for name, value in other.state_dict().items():
        source = before[name] if name.startswith("2.") else one.state_dict()[name]
        assert torch.equal(value, source), name
    # Weight and bias of the first two layers: 3 * 4 * 9 + 4 and 4 + 4 numbers of 155.
    assert "4 of 6 tensors fit, 120 of 155 numbers" in report
    assert report.endswith(": 2")


def test_a_stranger_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"Nothing of these weights fits.*w.safetensors|w.saf"):
        load_what_fits(_saved(nn.Sequential(nn.Linear(3, 3)), tmp_path), _network(5))
    with pytest.raises(DataError, match="no weights here"):
        load_what_fits(tmp_path / "none.safetensors", _network(5))
