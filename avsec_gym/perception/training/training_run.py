"""A training at a step: what it learns by, keeps, and goes on from, bit for bit."""

from __future__ import annotations

import json
import logging
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from avsec_gym.errors import AvsecError
from avsec_gym.perception.training.arithmetic import calculating, choose_arithmetic
from avsec_gym.perception.training.batches import steps_of_epoch
from avsec_gym.perception.training.checkpoint import (
    Checkpoint,
    resume_network,
    resume_optimizer,
    save_checkpoint,
    start_or_resume,
)
from avsec_gym.perception.training.configuration import Machine, TrainingConfiguration
from avsec_gym.perception.training.curves import Curves, read_curves
from avsec_gym.perception.training.learning_rate import learning_rate
from avsec_gym.perception.training.task import Task
from avsec_gym.perception.training.weight_average import WeightAverage

_LOGGED_STEPS = 20
_MOST_SKIPPED = 20
_NORM = "gradient_norm"
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Compute:
    """What a training has spent."""

    samples: int
    """Seen so far, each as often as it was."""
    seconds: float
    """Seconds of steps alone, without validations and checkpoints."""
    arithmetic: str
    """Numbers that it calculates in, and why."""

    @property
    def images_per_hour(self) -> float | None:
        """Samples in an hour of steps; None before the first."""
        return 3600 * self.samples / self.seconds if self.seconds > 0 else None


@dataclass(frozen=True)
class HeldOutResult:
    """What a validation on held-out frames found."""

    step: int
    epoch: int
    metrics: dict[str, float]
    is_best: bool
    seconds: float
    """Seconds of training so far."""
    compute: Compute


class TrainingRun:
    """A training at a step: its weights, optimiser, average and curves, in a folder.

    Args:
        task: The task, whose network is trained in place.
        configuration: What the result depends on.
        folder: The folder of the run: checkpoint and curves.
        machine: The device.
        resume: Whether the run in the folder goes on, if there is one.

    Raises:
        DataError: The folder holds a run and `resume` is false, or one of another configuration.
    """

    def __init__(
        self,
        task: Task[Any],
        configuration: TrainingConfiguration,
        folder: Path,
        machine: Machine,
        resume: bool,
    ) -> None:
        self.task, self.configuration, self.folder = task, configuration, folder
        self.device = torch.device(machine.device)
        if self.device.type == "cuda":
            # Sizes stay the same from step to step: cuDNN looks for its quickest way once.
            torch.backends.cudnn.benchmark = True
            torch.set_float32_matmul_precision("high")
        self.epoch_steps = steps_of_epoch(task.samples, configuration.batch)
        self.steps = self.epoch_steps * configuration.epochs
        self.trained = task.trained.to(self.device).train()
        self.optimizer = _optimizer(self.trained, configuration)
        self.average = WeightAverage(self.trained, configuration.average)
        self.state = self._begin(resume)
        self.curves = Curves(folder, self.state.step)
        self._since = time.monotonic()
        self._recent: list[dict[str, Tensor]] = []
        self._skipped = 0

    def _begin(self, resume: bool) -> Checkpoint:
        identity = json.loads(
            json.dumps(
                {
                    "task": self.task.name,
                    "samples": self.task.samples,
                    **self.task.description(),
                    "training": asdict(self.configuration),
                }
            )
        )
        state = start_or_resume(self.folder, identity, resume=resume)
        if state.trained:
            average = resume_network(state, self.trained, self.folder)
            self.average.weights = {name: value.to(self.device) for name, value in average.items()}
            resume_optimizer(state, self.optimizer, self.folder)
        return state

    @property
    def epoch(self) -> int:
        """Epochs that are done."""
        return self.state.step // self.epoch_steps

    @property
    def compute(self) -> Compute:
        """What was spent so far."""
        each = min(self.configuration.batch, self.task.samples)
        return Compute(each * self.state.step, self.state.compute_seconds, self.state.arithmetic)

    @property
    def is_validation_due(self) -> bool:
        """Whether the weights of this step are still to be validated."""
        step = self.state.step
        done, rest = divmod(step, self.epoch_steps)
        is_due = rest == 0 and (done % self.configuration.validate_every == 0 or step == self.steps)
        return is_due and step > self.state.validated

    @property
    def is_logged(self) -> bool:
        """Whether losses are written after this step."""
        return self.state.step % min(_LOGGED_STEPS, self.epoch_steps) == 0

    def step(self, prepared: Iterator[Any]) -> None:
        """Learn from the next batch.

        Raises:
            AvsecError: The gradient was not finite in too many steps on end.
        """
        began = time.monotonic()
        step, configuration = self.state.step, self.configuration
        batch = next(prepared).to(self.device)
        if self.state.bfloat16 is None:
            choice = choose_arithmetic(configuration.arithmetic, self.task, batch)
            self.state.bfloat16, self.state.arithmetic = choice.bfloat16, str(choice)
            began = time.monotonic()
        # All randomness of a step follows from its number: nothing to store, nothing to lose.
        torch.manual_seed((configuration.seed << 32) + step)
        for group in self.optimizer.param_groups:
            group["lr"] = learning_rate(step, self.steps, configuration)
        self.optimizer.zero_grad(set_to_none=True)
        with calculating(self.state.bfloat16, self.device):
            losses = self.task.losses(batch)
            total = torch.stack([loss.float() for loss in losses.values()]).sum()
        # A step whose loss or gradient is not finite is skipped; too many of them end the training.
        total.backward()  # type: ignore[no-untyped-call]
        norm = nn.utils.clip_grad_norm_(self.trained.parameters(), configuration.clip)
        if torch.isfinite(norm) and torch.isfinite(total):
            self.optimizer.step()
            self._skipped = 0
            terms = {name: loss.detach() for name, loss in losses.items()}
            self._recent.append(terms | {"total": total.detach(), _NORM: norm.detach()})
        else:
            self._skip()
        self.average.update(step)
        self.state.step = step + 1
        self._count_time()
        self.state.compute_seconds += time.monotonic() - began
        if self.is_logged:
            self._log()

    def validate(self, keep: Callable[[nn.Module, HeldOutResult], None] | None) -> HeldOutResult:
        """Validate the averaged weights, and keep them where they are the best so far."""
        state = self.state
        with self.average.applied():
            with torch.no_grad():
                metrics = self.task.validate()
            leading = metrics[self.task.leading_metric]
            best = -math.inf if state.best is None else state.best
            is_better = math.isfinite(leading) and leading > best
            # Of equals, such as the zeros in the beginning, the last is kept.
            is_best = is_better or leading == state.best
            self._count_time()
            validation = HeldOutResult(
                state.step, self.epoch, metrics, is_best, state.seconds, self.compute
            )
            if is_best and keep is not None:
                keep(self.task.network, validation)
        if is_best:
            state.best, state.best_step = leading, state.step
        state.validated = state.step
        state.without_better = 0 if is_better else state.without_better + 1
        patience = self.configuration.patience
        out_of_patience = patience is not None and state.without_better >= patience
        state.finished = out_of_patience or state.step == self.steps
        self.curves.add(state.step, "metrics", metrics, seconds=round(state.seconds, 1))
        self.curves.draw()
        return validation

    def last_validation(self) -> HeldOutResult | None:
        """The one that a finished training ended with."""
        if not self.state.finished:
            return None
        row = [row for row in read_curves(self.folder) if "metrics" in row][-1]
        is_best = row["step"] == self.state.best_step
        return HeldOutResult(
            row["step"], self.epoch, row["metrics"], is_best, row["seconds"], self.compute
        )

    def save(self) -> None:
        """Write a checkpoint."""
        self._count_time()
        self.state.trained = _on_cpu(self.trained.state_dict())
        self.state.average = _on_cpu(self.average.weights)
        self.state.optimizer = _on_cpu(self.optimizer.state_dict())
        save_checkpoint(self.folder, self.state)

    def _skip(self) -> None:
        self._skipped += 1
        _LOG.warning("step %d: the gradient is not finite; the step is left out", self.state.step)
        if self._skipped >= _MOST_SKIPPED:
            raise AvsecError(
                f"{self.folder}: no finite gradient in {self._skipped} steps on end. Begin anew "
                "with a lower --learning-rate, or with --arithmetic float32."
            )

    def _log(self) -> None:
        """The mean of every term over the steps that had it, since the last time."""
        means = {
            name: float(
                torch.stack([row[name].float() for row in self._recent if name in row]).mean()
            )
            for name in dict.fromkeys(name for row in self._recent for name in row)
        }
        self._recent.clear()
        if means:
            facts = {
                _NORM: means.pop(_NORM),
                "rate": float(self.optimizer.param_groups[0]["lr"]),
                "images_per_hour": round(self.compute.images_per_hour or 0.0),
                "seconds": round(self.state.seconds, 1),
            }
            self.curves.add(self.state.step, "losses", means, **facts)

    def _count_time(self) -> None:
        now = time.monotonic()
        self.state.seconds += now - self._since
        self._since = now


def _on_cpu(value: Any) -> Any:
    """A state with its tensors on the CPU, so that a run may go on on a machine without a GPU."""
    if isinstance(value, torch.Tensor):
        return value.cpu()
    if isinstance(value, dict):
        return {key: _on_cpu(part) for key, part in value.items()}
    return value


def _optimizer(trained: nn.Module, configuration: TrainingConfiguration) -> torch.optim.AdamW:
    """AdamW that decays weights but neither biases nor the scales of normalisations."""
    parameters = [value for value in trained.parameters() if value.requires_grad]
    groups: list[dict[str, Any]] = [
        {"params": [value for value in parameters if value.ndim > 1]},
        {"params": [value for value in parameters if value.ndim <= 1], "weight_decay": 0.0},
    ]
    return torch.optim.AdamW(
        [group for group in groups if group["params"]],
        lr=configuration.learning_rate,
        weight_decay=configuration.weight_decay,
        fused=True,
    )
