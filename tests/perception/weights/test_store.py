"""Weights as files: what goes in comes out, and what does not fit is named."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import nn

from avsec_gym.errors import DataError
from avsec_gym.perception.weights import store
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import load_weights, read_card, save_weights

CARD = ModelCard("toy", metrics={"precision": 0.5}, command="avsec train toy", steps=7)


def network(seed: int, wide: int = 3) -> nn.Module:
    torch.manual_seed(seed)
    return nn.Sequential(nn.Linear(2, wide), nn.BatchNorm1d(wide), nn.Linear(wide, 1))


@pytest.mark.parametrize(("storage", "error"), [("float32", 0.0), ("float16", 1e-3)])
def test_weights_come_back_as_they_were_stored(tmp_path: Path, storage: str, error: float) -> None:
    path = tmp_path / "toy.safetensors"
    written = save_weights(path, network(1), replace(CARD, storage=storage))
    loaded = network(2)
    assert load_weights(path, loaded) == written == read_card(path)
    for name, value in network(1).state_dict().items():
        found = loaded.state_dict()[name]
        assert found.dtype == value.dtype
        assert float((found - value).abs().max()) <= error * float(value.abs().max() + 1e-9)
    assert written.parameters == 2 * 3 + 3 + 3 + 3 + 3 + 1
    assert (path.stat().st_size < 1000) or storage == "float32"


def test_weights_of_another_network_are_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "toy.safetensors"
    save_weights(path, network(1), CARD)
    with pytest.raises(DataError, match=r"of another shape: 0.weight \(3, 2\) instead of \(4, 2\)"):
        load_weights(path, network(1, wide=4))
    with pytest.raises(DataError, match=r"1 missing: 3.weight"):
        load_weights(path, nn.Sequential(*network(1), nn.Linear(1, 1, bias=False)))
    with pytest.raises(DataError, match=r"2 unexpected: 2.bias, 2.weight"):
        load_weights(path, network(1)[:2])  # type: ignore[index]


def test_damaged_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "toy.safetensors"
    with pytest.raises(DataError, match=r"There are no weights"):
        load_weights(path, network(1))
    save_weights(path, network(1), CARD)
    whole = path.read_bytes()
    path.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    with pytest.raises(DataError, match=r"not the one of its card"):
        load_weights(path, network(1))
    path.write_bytes(whole[:50])
    with pytest.raises(DataError, match=r"no sound one of safetensors"):
        load_weights(path, network(1))
    path.with_suffix(".json").write_text(json.dumps([1]))
    with pytest.raises(DataError, match=r"else than a JSON object"):
        read_card(path)


def test_weights_that_half_precision_cannot_hold_are_not_stored(tmp_path: Path) -> None:
    large = network(1)
    with torch.no_grad():
        large[0].weight[0, 0] = 1e6  # type: ignore[index]
    with pytest.raises(DataError, match=r"0.weight is not finite, or beyond torch.float16"):
        save_weights(tmp_path / "toy.safetensors", large, CARD)
    assert not list(tmp_path.iterdir())


def test_all_that_comes_with_the_package_states_its_licence() -> None:
    """Where a card was silent, the site called the weights unlicensed."""
    folder = Path(store.__file__).parent
    cards = {path.stem: read_card(path) for path in sorted(folder.glob("*.safetensors"))}
    assert len(cards) >= 10
    assert {name for name, card in cards.items() if card is None or card.license != "MIT"} == set()
