"""The tasks by name: what `avsec train NAME` trains.

A task of a new network is a function from `TaskOptions` to a `Task`, named in `_TASKS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.task import Task
from avsec_gym.perception.training.training_assets import remark_on_assets
from avsec_gym.progress import Progress

if TYPE_CHECKING:
    from torch import nn

    from avsec_gym.perception.weights.model_card import ModelCard

_TASKS = {
    "dsgn": "avsec_gym.perception.training.stereo_tasks:dsgn_task",
    "stereo_rcnn": "avsec_gym.perception.training.stereo_tasks:stereo_rcnn_task",
    "faster_rcnn": "avsec_gym.perception.training.image_tasks:faster_rcnn_task",
    "yolo": "avsec_gym.perception.training.image_tasks:yolo_task",
    "psmnet": "avsec_gym.perception.training.stereo_tasks:psmnet_task",
    "pixor": "avsec_gym.perception.training.pixor_task:pixor_task",
    "pointrcnn": "avsec_gym.perception.training.pointrcnn_task:pointrcnn_task",
    "motion": "avsec_gym.perception.training.motion_task:motion_task",
    "road_type": "avsec_gym.perception.training.road_type_task:road_type_task",
}
TASKS = tuple(_TASKS)
"""Names of the tasks."""


@dataclass(frozen=True)
class TaskOptions:
    """What a task is made of.

    Args:
        preset: The preset of the network's configuration.
        data: Folders in KITTI's object layout; small suites of training assets if there are none.
        validation: Folders to validate on; the splits ``val`` of `data` if there are none.
        cache: Folder for what is computed once from the data.
        start: Weights to begin with, as `save_weights` writes them; random ones if None.
        augmentation: The augmentation of training samples.
        seed: The seed of random weights.
        on_progress: Function that gets frames prepared and frames in all.
        on_report: Function that gets what a user should know, such as which weights did not fit, or
            which data are of assets that detectors are judged on.
    """

    preset: str
    data: tuple[Path, ...]
    validation: tuple[Path, ...]
    cache: Path
    start: Path | None = None
    augmentation: Augmentation = field(default_factory=Augmentation)
    seed: int = 0
    on_progress: Progress | None = None
    on_report: Callable[[str], None] | None = None

    def begin(self, network: nn.Module) -> ModelCard | None:
        """Give a network the weights to begin with, if there are any; their card.

        Weights of another configuration are taken as far as they fit, and what fits is reported.

        Args:
            network: Network to be given the weights, in place.

        Raises:
            DataError: The file is missing or damaged, or nothing of it fits.
        """
        from avsec_gym.perception.weights.partial import load_what_fits

        if self.start is None:
            return None
        card, report = load_what_fits(self.start, network)
        if report and self.on_report is not None:
            self.on_report(report)
        return card


def make_task(name: str, options: TaskOptions) -> Task[Any]:
    """A task by its name.

    Raises:
        ConfigurationError: An unknown task or preset.
        DataError: There are no data; the command that makes them is named.
    """
    if name not in _TASKS:
        raise ConfigurationError(
            f"nothing named {name!r} can be trained; known: {', '.join(TASKS)}"
        )
    remark = remark_on_assets((*options.data, *options.validation))
    if remark is not None and options.on_report is not None:
        options.on_report(remark)
    module, function = _TASKS[name].split(":")
    task: Task[Any] = getattr(import_module(module), function)(options)
    return task
