"""What all tasks on stereo pairs share: samples, and batches of them that are varied."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from avsec_gym.perception.training.augmentation import augmented
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.sample import StereoSampleBatch, sample_batch
from avsec_gym.perception.training.stereo_samples import StereoSamples, prepare_samples
from avsec_gym.perception.training.tasks import TaskOptions
from avsec_gym.perception.training.training_data import training_data


class StereoTask:
    """The part of a `Task` that does not depend on the network.

    Args:
        training: Samples of the network's input size.
        validation: Other samples of this size.
        augmentation: The augmentation of training samples.
        data: JSON-able: what the samples are.
    """

    def __init__(
        self,
        training: StereoSamples,
        validation: StereoSamples,
        augmentation: Augmentation,
        data: dict[str, Any],
    ) -> None:
        self._training, self._validation = training, validation
        self._augmentation, self._data = augmentation, data

    @property
    def samples(self) -> int:
        """See `Task`."""
        return len(self._training)

    def batch(self, indices: Sequence[int], randomness: np.random.Generator) -> StereoSampleBatch:
        """See `Task`."""
        samples = [self._training[index] for index in indices]
        return sample_batch(
            [augmented(sample, self._augmentation, randomness) for sample in samples]
        )


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
