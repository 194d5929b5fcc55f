"""In which numbers a training calculates: decided by a measurement of its own steps.

A processor's flags decide nothing: some are quicker in bfloat16 without a flag that
promises it, others slower with one, and it depends on the network.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import torch
from torch import nn

from avsec_gym.perception.training.task import Task

Arithmetic = Literal["measured", "float32", "bfloat16"]

_PAYS = 0.9
"""bfloat16 is chosen where its step takes less than this share of the time."""
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Choice:
    """What a training calculates in, and why.

    Args:
        bfloat16: Whether in bfloat16 where that is safe (`torch.autocast`), else in float32.
        float32_seconds: The seconds of a step; None where it was not measured.
        bfloat16_seconds: The seconds of a step in bfloat16; None where it was not measured.
    """

    bfloat16: bool
    float32_seconds: float | None = None
    bfloat16_seconds: float | None = None

    def __str__(self) -> str:
        """The arithmetic in words, for logs and cards."""
        name = "bfloat16" if self.bfloat16 else "float32"
        if self.float32_seconds is None or self.bfloat16_seconds is None:
            return f"{name}, as asked for"
        return (
            f"{name}: a step took {self.float32_seconds:.3f} s in float32,"
            f" {self.bfloat16_seconds:.3f} s in bfloat16"
        )


def choose_arithmetic(
    wish: Arithmetic,
    task: Task[Any],
    batch: Any,
    *,
    rounds: int = 3,
    clock: Callable[[], float] = time.perf_counter,
) -> Choice:
    """What to calculate in.

    Measuring leaves no trace: weights, statistics and gradients are as they were.  The two take
    turns, and the quickest step of each counts, so that other programs disturb both alike.

    Args:
        wish: The arithmetic that is asked for, or ``measured``.
        task: The task, whose `trained` stands on the device, in training mode.
        batch: A batch on the device.
        rounds: Steps of each, after one that is not counted.
        clock: The clock, in seconds.
    """
    if wish != "measured":
        return Choice(wish == "bfloat16")
    state = {name: value.clone() for name, value in task.trained.state_dict().items()}
    device = next(task.trained.parameters()).device
    best = {False: float("inf"), True: float("inf")}
    finite = True
    for number in range(rounds + 1):
        for bfloat16 in best:
            torch.manual_seed(0)
            began = clock()
            finite &= _step(task, batch, bfloat16, device)
            seconds = clock() - began
            if number > 0:
                best[bfloat16] = min(best[bfloat16], seconds)
    task.trained.load_state_dict(state)
    task.trained.zero_grad(set_to_none=True)
    choice = Choice(finite and best[True] < _PAYS * best[False], best[False], best[True])
    _LOG.info("%s", choice)
    return choice


def calculating(choice_bfloat16: bool, device: torch.device) -> torch.autocast:
    """The context in which losses are calculated."""
    return torch.autocast(device.type, torch.bfloat16, enabled=choice_bfloat16)


def _step(task: Task[Any], batch: Any, bfloat16: bool, device: torch.device) -> bool:
    """Forward, loss and backward; whether all gradients are finite."""
    task.trained.zero_grad(set_to_none=True)
    with calculating(bfloat16, device):
        losses = task.losses(batch)
        total = torch.stack([loss.float() for loss in losses.values()]).sum()
    total.backward()  # type: ignore[no-untyped-call]
    norm = nn.utils.clip_grad_norm_(task.trained.parameters(), float("inf"))
    if device.type == "cuda":
        torch.cuda.synchronize(device)
    return bool(torch.isfinite(norm) & torch.isfinite(total))
