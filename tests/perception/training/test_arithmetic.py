"""Numbers are chosen by what steps take, and a measurement leaves no trace."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from avsec_gym.perception.training.arithmetic import Choice, choose_arithmetic


class Steps:
    """A task whose steps take what they are told to, by a clock of their own."""

    name, leading_metric, samples = "steps", "precision", 8

    def __init__(self, float32: list[float], bfloat16: list[float]) -> None:
        self.network = nn.Sequential(nn.Linear(2, 2), nn.BatchNorm1d(2), nn.Dropout())
        self.trained: nn.Module = self.network
        self.now, self._takes = 0.0, {False: iter(float32), True: iter(bfloat16)}

    def clock(self) -> float:
        return self.now

    def losses(self, batch: Tensor) -> dict[str, Tensor]:
        is_bfloat16 = torch.is_autocast_enabled("cpu")
        assert (self.network[0](batch).dtype == torch.bfloat16) == is_bfloat16
        self.now += next(self._takes[is_bfloat16])
        return {"square": (self.network(batch) ** 2).mean()}


def _choice(task: Steps, batch: Tensor | None = None) -> Choice:
    batch = torch.randn(4, 2) if batch is None else batch
    return choose_arithmetic("measured", task, batch, rounds=3, clock=task.clock)


@pytest.mark.parametrize(
    ("float32", "bfloat16", "pays"),
    [
        # The first of each warms up and does not count.
        ([9, 1, 1, 1], [9, 0.8, 0.8, 0.8], True),
        ([9, 1, 1, 1], [9, 0.95, 0.95, 0.95], False),
        # Of steps that were disturbed, the quickest counts.
        ([9, 1, 7, 7], [9, 8, 8, 0.8], True),
        ([0.1, 1, 1, 1], [9, 0.8, 0.8, 0.8], True),
        ([9, 1, 1, 1], [0.1, 2, 2, 2], False),
    ],
)
def test_the_quicker_one_is_taken_if_it_is_so_by_a_margin(
    float32: list[float], bfloat16: list[float], pays: bool
) -> None:
    choice = _choice(Steps(float32, bfloat16))
    assert choice.bfloat16 == pays
    assert choice.float32_seconds == pytest.approx(min(float32[1:]))
    assert choice.bfloat16_seconds == pytest.approx(min(bfloat16[1:]))
    assert str(choice).startswith("bfloat16: a step" if pays else "float32: a step")


def test_numbers_that_overflow_are_not_taken() -> None:
    batch = torch.full((4, 2), torch.inf)
    assert not _choice(Steps([1.0] * 4, [0.1] * 4), batch).bfloat16


def test_measuring_leaves_no_trace() -> None:
    task = Steps([1.0] * 4, [1.0] * 4)
    before = {name: value.clone() for name, value in task.trained.state_dict().items()}
    _choice(task)
    for name, value in task.trained.state_dict().items():
        assert torch.equal(value, before[name]), name
    assert all(value.grad is None for value in task.trained.parameters())


@pytest.mark.parametrize("wish", ["float32", "bfloat16"])
def test_what_is_told_is_not_measured(wish: str) -> None:
    refuse: Callable[[], float] = lambda: pytest.fail("measured")  # noqa: E731
    task = Steps([], [])
    choice = choose_arithmetic(wish, task, np.zeros(1), clock=refuse)
    assert choice == Choice(wish == "bfloat16")
    assert str(choice) == f"{wish}, as asked for"
