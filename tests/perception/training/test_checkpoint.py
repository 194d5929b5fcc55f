"""A training's checkpoint with something else in it than a training writes: refused by its name."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
import torch
from torch import nn

from avsec_gym.errors import DataError
from avsec_gym.perception.training.checkpoint import (
    Checkpoint,
    resume_network,
    resume_optimizer,
    save_checkpoint,
    start_or_resume,
)

WRONG: tuple[Any, ...] = (
    *(None, True, "a", b"a", 1j, -1, 10**30, float("nan"), float("inf"), -1.0, 1e308),
    *([], {}, [1, [2]], {1: 2}, {"a": None}, {"a": {"b": []}}),
    *(
        torch.tensor(1.0),
        torch.zeros(2),
        torch.zeros(0),
        torch.tensor(True),
        torch.full((2, 2), torch.nan),
    ),
)


def network() -> nn.Module:
    torch.manual_seed(0)
    return nn.Linear(3, 2)


def learned() -> tuple[nn.Module, torch.optim.Optimizer]:
    one = network()
    optimizer = torch.optim.AdamW(one.parameters())
    sum(value.sum() for value in one.parameters()).backward()  # type: ignore[union-attr]
    optimizer.step()
    return one, optimizer


def checkpoint() -> Checkpoint:
    one, optimizer = learned()
    state = one.state_dict()
    return Checkpoint({"seed": 0}, 7, state, state, optimizer.state_dict(), best=0.5)


def resumed(folder: Path) -> Checkpoint:
    """As a training that goes on; a step shows what it begins with."""
    state = start_or_resume(folder, {"seed": 0}, resume=True)
    one, optimizer = learned()
    if state.trained:
        resume_network(state, one, folder)
        resume_optimizer(state, optimizer, folder)
    optimizer.step()
    assert all(value.isfinite().all() for value in one.parameters())
    return state


@pytest.mark.parametrize("name", [field.name for field in fields(Checkpoint)])
def test_whatever_stands_in_a_field_is_taken_or_refused_by_the_file(
    name: str, tmp_path: Path
) -> None:
    sound, refused = checkpoint(), 0
    for wrong in WRONG:
        changed = Checkpoint(**{**vars(sound), name: wrong})
        save_checkpoint(tmp_path, changed)
        try:
            resumed(tmp_path)
        except DataError as error:
            assert str(tmp_path) in str(error)  # noqa: PT017
            refused += 1
    assert refused > len(WRONG) / 2
    save_checkpoint(tmp_path, sound)
    assert resumed(tmp_path).step == 7


def test_whatever_the_optimizer_remembers_is_taken_or_refused_by_the_file(tmp_path: Path) -> None:
    """Of the settings nothing counts but the rate: they are the configuration's."""
    sound = checkpoint()
    state, groups = sound.optimizer["state"], sound.optimizer["param_groups"]
    for owner in (sound.optimizer, state, groups, state[0], groups[0]):
        for name in range(len(owner)) if isinstance(owner, list) else list(owner):
            right = owner[name]
            for wrong in WRONG:
                owner[name] = wrong
                save_checkpoint(tmp_path, sound)
                try:
                    resumed(tmp_path)
                except DataError as error:
                    assert str(tmp_path) in str(error)  # noqa: PT017
            owner[name] = right


@pytest.mark.parametrize(("value", "words"), [(torch.inf, "not finite"), (2e30, "more than any")])
def test_an_average_that_cannot_be_is_refused(tmp_path: Path, value: float, words: str) -> None:
    sound = checkpoint()
    spoilt = {name: torch.full_like(kept, value) for name, kept in sound.average.items()}
    save_checkpoint(tmp_path, Checkpoint(**{**vars(sound), "average": spoilt}))
    with pytest.raises(DataError, match=words):
        resumed(tmp_path)
