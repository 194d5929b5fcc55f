"""What all tasks on stereo pairs share: samples, and batches of them that are varied."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.training.augmentation import augmented
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.sample import PackedBatch, packed_batch
from avsec_gym.perception.training.stereo_samples import StereoSamples, prepare_samples
from avsec_gym.perception.training.tasks import TaskOptions
from avsec_gym.perception.training.training_data import training_data


@dataclass(frozen=True)
class StereoBatchMaker:
    """Makes batches of samples that are varied, in other processes, too.

    Args:
        samples: The samples.
        augmentation: The augmentation of the samples.
        targets: Function that makes of the objects what the losses need of them alone; None for
            nothing.
    """

    samples: StereoSamples
    augmentation: Augmentation
    targets: Callable[[Sequence[Boxes3D]], Any] | None = None

    def __call__(self, indices: Sequence[int], randomness: np.random.Generator) -> PackedBatch:
        """See `Task.batch`."""
        made = [augmented(self.samples[index], self.augmentation, randomness) for index in indices]
        targets = None if self.targets is None else self.targets([each.truth for each in made])
        return packed_batch(made, targets)


class StereoTask:
    """The part of a `Task` that does not depend on the network.

    Args:
        training: Samples of the network's input size.
        validation: Other samples of this size.
        augmentation: The augmentation of training samples.
        data: JSON-able: what the samples are.
        targets: Function that makes the targets, see `StereoBatchMaker`.
    """

    def __init__(
        self,
        training: StereoSamples,
        validation: StereoSamples,
        augmentation: Augmentation,
        data: dict[str, Any],
        targets: Callable[[Sequence[Boxes3D]], Any] | None = None,
    ) -> None:
        self._training, self._validation = training, validation
        self._augmentation, self._data = augmentation, data
        self.batch = StereoBatchMaker(training, augmentation, targets)
        """See `Task`."""

    @property
    def samples(self) -> int:
        """See `Task`."""
        return len(self._training)


def stereo_samples(
    options: TaskOptions, size: tuple[int, int] | None
) -> tuple[StereoSamples, StereoSamples, Augmentation, dict[str, Any]]:
    """What a `StereoTask` is made of.

    Args:
        options: The options of the task.
        size: Height and width of the network's input.

    Raises:
        DataError: There are no data; the command that makes them is named.
    """
    data = training_data(options.data, options.validation)
    training, validation = (
        prepare_samples(frames, size, options.cache, on_progress=options.on_progress)
        for frames in (data.training, data.validation)
    )
    return training, validation, options.augmentation, data.description()
