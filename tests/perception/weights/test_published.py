"""Published checkpoints: every wrapping that authors use, and no code from strangers."""

from __future__ import annotations

import pickle
from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from avsec_gym.cli import run
from avsec_gym.errors import DataError
from avsec_gym.perception.depth.psmnet import PsmNet, PsmNetConfiguration
from avsec_gym.perception.weights.published import load_published
from avsec_gym.perception.weights.store import load_weights, read_card


def network(seed: int) -> nn.Module:
    torch.manual_seed(seed)
    return nn.Sequential(nn.Linear(2, 3), nn.BatchNorm1d(3))


def plain() -> dict[str, Tensor]:
    return dict(network(1).state_dict())


def parallel() -> dict[str, Tensor]:
    return {f"module.{name}": value for name, value in plain().items()}


@pytest.mark.parametrize(
    "content",
    [
        plain(),
        parallel(),
        {"epoch": 3, "state_dict": parallel(), "train_loss": 0.1, "optimizer": {"lr": [1.0]}},
        {"session": 1, "model": plain(), "pooling_mode": "align", "class_agnostic": False},
        # Before torch 0.4.1 batches were not counted.
        {"state_dict": {k: v for k, v in parallel().items() if "batches" not in k}},
    ],
)
def test_every_wrapping_is_taken_off(tmp_path: Path, content: Any) -> None:
    path = tmp_path / "published.tar"
    torch.save(content, path, _use_new_zipfile_serialization=False)
    loaded = network(2)
    load_published(path, loaded)
    for name, value in plain().items():
        assert torch.equal(loaded.state_dict()[name], value)


def test_other_networks_are_named(tmp_path: Path) -> None:
    path = tmp_path / "published.pth"
    state = plain() | {"3.weight": torch.zeros(2)}
    del state["0.bias"]
    torch.save({"state_dict": state}, path)
    with pytest.raises(DataError, match=r"1 missing: 0.bias; 1 unexpected: 3.weight"):
        load_published(path, network(1))
    torch.save({"state_dict": plain() | {"0.bias": torch.full((3,), torch.nan)}}, path)
    with pytest.raises(DataError, match=r"0.bias holds a value that is not finite"):
        load_published(path, network(1))
    torch.save({"state_dict": plain() | {"0.bias": torch.full((3,), -6e37)}}, path)
    with pytest.raises(DataError, match=r"0.bias holds a value that is 6e\+37, more than any"):
        load_published(path, network(1))
    for nothing in ({}, {"epoch": 3}, torch.zeros(3)):
        torch.save(nothing, path)
        with pytest.raises(DataError, match=r"no dictionary of tensors"):
            load_published(path, network(1))


class Evil:
    """Would write a file when unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return (Path.touch, (self.path,))


def test_code_in_a_checkpoint_is_never_run(tmp_path: Path) -> None:
    trace, path = tmp_path / "trace", tmp_path / "evil.pth"
    # Beside the tensors it does no harm: it is not made.
    torch.save({"state_dict": plain(), "extra": Evil(trace)}, path)
    load_published(path, network(1))
    for among_tensors in ({"state_dict": plain() | {"0.bias": Evil(trace)}}, Evil(trace)):
        torch.save(among_tensors, path)
        with pytest.raises(DataError, match=r"missing: 0.bias|no dictionary of tensors"):
            load_published(path, network(1))
    path.write_bytes(pickle.dumps(Evil(trace)))
    with pytest.raises(DataError):
        load_published(path, network(1))
    path.write_bytes(b"PK\x03\x04 nonsense")
    with pytest.raises(DataError):
        load_published(path, network(1))
    assert not trace.exists()
    with pytest.raises(DataError, match=r"no such file"):
        load_published(tmp_path / "nowhere.pth", network(1))


def test_what_programs_keep_beside_their_tensors_is_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "published.pth"
    beside = {"loss": np.float64(0.25), "args": Namespace(lr=0.1), "history": {"x": np.arange(3)}}
    for content in ({"state_dict": plain(), **beside}, plain() | {"epoch": np.int64(3)}):
        for archive in (True, False):
            torch.save(content, path, _use_new_zipfile_serialization=archive)
            loaded = network(2)
            load_published(path, loaded)
            assert torch.equal(loaded.state_dict()["0.weight"], plain()["0.weight"])


@pytest.mark.filterwarnings("ignore:.*(quantized|Sparse|deprecated)")
@pytest.mark.parametrize("kind", ["sparse", "q"])
def test_sparse_and_quantised_tensors_are_named(tmp_path: Path, kind: str) -> None:
    weight = nn.Linear(3, 2).weight.detach()
    strange = (
        weight.to_sparse()
        if kind == "sparse"
        else torch.quantize_per_tensor(weight, 0.1, 0, torch.qint8)
    )
    path = tmp_path / "other.pth"
    torch.save({"state_dict": {"weight": strange, "bias": torch.zeros(2)}}, path)
    with pytest.raises(DataError, match=rf"other\.pth.*weight is no plain tensor \({kind}_?ten"):
        load_published(path, nn.Linear(3, 2))


def test_a_variance_is_not_below_zero(tmp_path: Path) -> None:
    """Its root is nan, and so was all that such a network found."""
    path = tmp_path / "published.pth"
    torch.save(plain() | {"1.running_var": torch.tensor([1.0, -0.5, 1.0])}, path)
    with pytest.raises(DataError, match=r"1.running_var holds a value that is below 0"):
        load_published(path, network(1))


def test_a_weight_is_there_once(tmp_path: Path) -> None:
    """Of two with and without the prefix, the one that came last was taken without a word."""
    path = tmp_path / "published.pth"
    torch.save(plain() | {"module.0.bias": torch.zeros(3)}, path)
    with pytest.raises(DataError, match=r"0.bias is there twice"):
        load_published(path, network(1))


@pytest.mark.parametrize("kind", [torch.complex64, torch.int8, torch.uint8, torch.bool])
def test_numbers_of_another_kind_are_no_weights(tmp_path: Path, kind: torch.dtype) -> None:
    path = tmp_path / "published.pth"
    torch.save(plain() | {"0.bias": plain()["0.bias"].to(kind)}, path)
    with pytest.raises(DataError, match=r"0.bias holds numbers of the type"):
        load_published(path, network(1))
    half = {name: value.half() if value.ndim else value for name, value in plain().items()}
    torch.save(half, path)
    load_published(path, network(1))
    torch.save(plain() | {"0.bias": torch.full((3,), 1e300, dtype=torch.float64)}, path)
    with pytest.raises(DataError, match=r"0.bias holds a value that is not finite"):
        load_published(path, network(1))


def test_command_imports_a_full_psmnet(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, out = tmp_path / "pretrained.tar", tmp_path / "psmnet.safetensors"
    torch.manual_seed(0)
    original = PsmNet(PsmNetConfiguration.preset("full"))
    state = {f"module.{name}": value for name, value in original.state_dict().items()}
    torch.save({"epoch": 10, "state_dict": state}, source)
    arguments = ["weights", "import", str(source), "--network", "psmnet", "--out", str(out)]
    arguments.append("--aligned-corners")
    assert run(arguments) == 0
    loaded = PsmNet(PsmNetConfiguration.preset("full").with_corners(True))
    card = load_weights(out, loaded)
    assert card == read_card(out)
    assert card is not None
    assert (card.parameters, card.source) == (5224768, "published checkpoint pretrained.tar")
    for name, value in original.state_dict().items():
        assert torch.equal(loaded.state_dict()[name], value)
    capsys.readouterr()
    assert run(arguments) == 1
    assert "--overwrite" in capsys.readouterr().err
    wrong = [*arguments[:-1], "--overwrite"]
    wrong[4] = "dsgn"
    assert run(wrong) == 1
    error = capsys.readouterr().err
    assert "another network" in error
    assert "missing: " in error
