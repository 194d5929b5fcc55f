"""`avsec train`: trains a network, in as many sittings as it takes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from avsec_gym import console
from avsec_gym.argument_checks import thread_number
from avsec_gym.command_line import command_line
from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.training.configuration import (
    Augmentation,
    Machine,
    TrainingConfiguration,
)

if TYPE_CHECKING:
    from torch import nn

    from avsec_gym.perception.training.task import Task
    from avsec_gym.perception.training.trainer import TrainingResult
    from avsec_gym.perception.training.training_run import Compute, HeldOutResult


WEIGHTS = "weights.safetensors"
"""The weights in the folder of a run that are kept."""
_SECONDS_BETWEEN_RATES = 300.0


@dataclass(frozen=True)
class Train:
    """Train a network; its weights are kept in --out with a model card.

    Also there: the checkpoint, curves (curves.jsonl, curves.png, TensorBoard), reduced images.
    """

    name: Annotated[
        Literal[
            "dsgn",
            "stereo_rcnn",
            "faster_rcnn",
            "yolo",
            "psmnet",
            "pixor",
            "pointrcnn",
            "motion",
            "road_type",
        ],
        tyro.conf.Positional,
    ]
    """Which network."""
    out: Path
    """Folder of the run."""
    data: tuple[Path, ...] = ()
    """Folders in KITTI's object layout, with ImageSets, such as `avsec world make` writes.
    Default: small suites of the procedural world's training assets, made on first use."""
    validation: tuple[Path, ...] = ()
    """Folders to validate on; all frames of --data are then learned from.  Default: the split
    `val` of --data."""
    preset: str = "small"
    """Preset of the network's configuration."""
    start: Path | None = None
    """Weights to begin with (.safetensors); those of another preset or network as far as they fit.
    Default: random ones."""
    resume: bool = False
    """Go on with the run in --out, or begin it."""
    keep: Literal["best", "last"] = "best"
    """Which weights are left in the end: those of the best validation, or the last, which are the
    better choice where a validation's noise exceeds what an epoch gains.  A training that is
    finished can be asked again, with --resume."""
    threads: int | None = None
    """Threads of the processor, for one step. Default: torch's choice."""
    cache: Path | None = None
    """Folder for reduced images, which several runs may share.  Default: in --out."""
    training: TrainingConfiguration = field(default_factory=TrainingConfiguration)
    """What the result depends on."""
    augmentation: Augmentation = field(default_factory=Augmentation)
    """How stereo pairs and scans are varied."""
    machine: Machine = field(default_factory=Machine)
    """Where to train, and how long in this sitting."""
    json: bool = False
    """Print a summary as JSON."""

    def run(self) -> int:
        """Do it; the exit code: 3 where time was up before the training was done."""
        import torch

        from avsec_gym.perception.training.tasks import TaskOptions, make_task
        from avsec_gym.perception.training.trainer import train
        from avsec_gym.storage.folder_lock import locked_folder
        from avsec_gym.storage.folders import made_folder

        if self.threads is not None:
            torch.set_num_threads(thread_number("--threads", self.threads))
        if self.machine.device.startswith("cuda") and not torch.cuda.is_available():
            raise ConfigurationError("--device cuda: torch sees no GPU here")
        # Samples are prepared once; then the network learns, and the better ones are kept.
        cache = self.cache or self.out / "samples"
        with locked_folder(self.out), made_folder(cache):
            with console.progress("preparing") as shown:
                options = TaskOptions(
                    self.preset,
                    self.data,
                    self.validation,
                    cache,
                    self.start,
                    self.augmentation,
                    self.training.seed,
                    shown,
                    console.say,
                )
                task = make_task(self.name, options)
            with console.progress("training") as shown:
                outcome = train(
                    task,
                    self.training,
                    self.out,
                    machine=self.machine,
                    resume=self.resume,
                    keep=lambda network, validation: self._keep(task, network, validation),
                    on_progress=shown,
                    on_compute=_rate_teller(),
                    on_validation=lambda validation: _tell(task, validation),
                )
            if self.keep == "last" and outcome.last is not None:
                self._keep(task, task.network, outcome.last)
        self._report(task, outcome)
        return console.DONE if outcome.finished else console.DONE_IN_PART

    def _keep(self, task: Task[Any], network: nn.Module, validation: HeldOutResult) -> None:
        import platform
        from dataclasses import asdict

        import torch

        from avsec_gym import __version__
        from avsec_gym.perception.weights.model_card import ModelCard
        from avsec_gym.perception.weights.store import read_card, save_weights

        description = task.description()
        began_with = None if self.start is None else read_card(self.start)
        card = ModelCard(
            task.name,
            configuration=description.pop("network"),
            data=description.pop("data", {}),
            training=asdict(self.training) | description,
            metrics=validation.metrics,
            beside={
                name: value.flatten().tolist()
                for name, value in task.trained.state_dict().items()
                if task.trained is not network and not name.startswith("network.")
            },
            steps=validation.step,
            epochs=validation.epoch,
            minutes=round(validation.seconds / 60, 1),
            samples_seen=validation.compute.samples,
            compute_seconds=round(validation.compute.seconds, 1),
            images_per_hour=_rounded(validation.compute.images_per_hour),
            arithmetic=validation.compute.arithmetic,
            hardware=_hardware(self.machine.device),
            command=command_line(),
            before=[] if began_with is None else began_with.trainings(),
            versions={
                "avsec_gym": __version__,
                "torch": torch.__version__,
                "python": platform.python_version(),
            },
        )
        save_weights(self.out / WEIGHTS, network, card)

    def _report(self, task: Task[Any], outcome: TrainingResult) -> None:
        summary = {
            "network": self.name,
            "out": str(self.out),
            "finished": outcome.finished,
            "steps": outcome.steps,
            "seconds": round(outcome.seconds, 1),
            "samples_seen": outcome.compute.samples,
            "compute_seconds": round(outcome.compute.seconds, 1),
            "images_per_hour": _rounded(outcome.compute.images_per_hour),
            "arithmetic": outcome.compute.arithmetic,
            task.leading_metric: outcome.best,
        }
        if self.json:
            console.print_json("train", summary)
            return
        best = "no validation yet" if outcome.best is None else f"best {outcome.best:.3f}"
        state = "finished" if outcome.finished else "time is up, --resume goes on"
        console.say(f"{self.out}: {state}; {outcome.steps} steps, {task.leading_metric}: {best}")


def _tell(task: Task[Any], validation: HeldOutResult) -> None:
    leading = validation.metrics[task.leading_metric]
    others = ", ".join(
        f"{name} {value:.3g}"
        for name, value in validation.metrics.items()
        if name != task.leading_metric
    )
    best = " (best so far)" if validation.is_best else ""
    console.say(
        f"epoch {validation.epoch}, {validation.seconds / 60:.0f} min, "
        f"{validation.compute.images_per_hour or 0:,.0f} images an hour: "
        f"{task.leading_metric} {leading:.3f}{best}; {others}"
    )


def _rate_teller() -> Callable[[Compute], None]:
    """Logs how quick a training is: at its begin, and then now and again."""
    logged = -math.inf

    def tell(compute: Compute) -> None:
        nonlocal logged
        if time.monotonic() - logged > _SECONDS_BETWEEN_RATES:
            first, logged = math.isinf(logged), time.monotonic()
            numbers = f"; {compute.arithmetic}" if first else ""
            rate = compute.images_per_hour or 0
            console.say(f"{compute.samples:,} samples seen, {rate:,.0f} images an hour{numbers}")

    return tell


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value)


def _hardware(device: str) -> str:
    import platform

    import torch

    if device.startswith("cuda"):
        return torch.cuda.get_device_name(device)
    threads = torch.get_num_threads()
    return f"{platform.machine()} processor, {threads} thread{'s' * (threads > 1)}"
