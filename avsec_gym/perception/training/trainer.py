"""The training loop, for any task: resumed exactly, stopped in time, the best weights kept."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from torch import nn

from avsec_gym.perception.training.batches import batches
from avsec_gym.perception.training.configuration import Machine, TrainingConfiguration
from avsec_gym.perception.training.task import B, Task
from avsec_gym.perception.training.training_run import Compute, HeldOutResult, TrainingRun
from avsec_gym.progress import Progress


@dataclass(frozen=True)
class TrainingResult:
    """How a training ended."""

    finished: bool
    """Whether all epochs are done, or no better result is to be expected."""
    steps: int
    seconds: float
    best: float | None
    """The highest leading metric."""
    last: HeldOutResult | None
    """The last of the averaged weights that the network was left with; None unless the training
    finished."""
    compute: Compute


def train(
    task: Task[B],
    configuration: TrainingConfiguration,
    folder: Path,
    *,
    machine: Machine = Machine(),
    resume: bool = False,
    keep: Callable[[nn.Module, HeldOutResult], None] | None = None,
    on_progress: Progress | None = None,
    on_compute: Callable[[Compute], None] | None = None,
    on_validation: Callable[[HeldOutResult], None] | None = None,
) -> TrainingResult:
    """Train a task's network.

    On a CPU, a run that was stopped and resumed has the weights of one that was not, bit for bit.

    Args:
        task: The task, whose network is left with the averaged weights of the end, in evaluation
            mode.
        configuration: What the result depends on.
        folder: The folder of the run: checkpoint and curves.
        machine: The device, and how long it may take.
        resume: Whether the run in the folder goes on, if there is one.
        keep: Function that gets the network, bearing averaged weights, at each better validation.
        on_progress: Function that gets steps done and steps in all, of this call.
        on_compute: Function that is called whenever losses are written, after some steps each.
        on_validation: Function that is called after each validation.

    Raises:
        DataError: The folder holds a run and `resume` is false, or one of another configuration.
        AvsecError: The loss stays infinite.
    """
    run = TrainingRun(task, configuration, folder, machine, resume)
    began, first = time.monotonic(), run.state.step
    deadline = math.inf if machine.minutes is None else began + 60 * machine.minutes
    saved = began
    with closing(run.curves):
        try:
            # Batches are prepared beside the steps, from the step on that the run has reached.
            prepared = batches(
                task,
                configuration,
                first,
                run.steps,
                machine.loaders,
                processes=run.device.type != "cpu",
                folder=folder,
            )
            with closing(prepared):
                while not run.state.finished and time.monotonic() < deadline:
                    # Also what a run was killed in the middle of.
                    if run.is_validation_due:
                        validation = run.validate(keep)
                        if on_validation is not None:
                            on_validation(validation)
                        run.save()
                        saved = time.monotonic()
                        continue
                    run.step(prepared)
                    if on_progress is not None:
                        on_progress(run.state.step - first, run.steps - first)
                    if on_compute is not None and run.is_logged:
                        on_compute(run.compute)
                    is_time = time.monotonic() - saved > 60 * machine.checkpoint_minutes
                    # A validation takes longer than a checkpoint.
                    if is_time or run.is_validation_due:
                        run.save()
                        saved = time.monotonic()
        except KeyboardInterrupt:
            run.save()
            raise
        run.save()
    # The network is left with the averaged weights.
    run.trained.load_state_dict(run.average.weights)
    run.trained.eval()
    state = run.state
    last = run.last_validation()
    return TrainingResult(state.finished, state.step, state.seconds, state.best, last, run.compute)
