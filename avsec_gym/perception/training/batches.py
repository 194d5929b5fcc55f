"""The batches of a training in their order, prepared ahead of time by threads."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from avsec_gym.perception.training.configuration import TrainingConfiguration
from avsec_gym.perception.training.task import B, Task

_AHEAD = 2
"""Batches that each thread keeps ready."""


def steps_of_epoch(samples: int, batch: int) -> int:
    """Whole batches in an epoch; the rest of its samples waits for another order."""
    return max(samples // batch, 1)


def batch_indices(
    step: int, samples: int, configuration: TrainingConfiguration
) -> NDArray[np.intp]:
    """Which samples a step takes: each epoch has an order of its own, by seed and epoch.

    Returns:
        Shape (batch,), fewer where there are fewer samples.
    """
    epoch, position = divmod(step, steps_of_epoch(samples, configuration.batch))
    order = np.random.default_rng([configuration.seed, epoch]).permutation(samples)
    return order[position * configuration.batch : (position + 1) * configuration.batch]


def batches(
    task: Task[B], configuration: TrainingConfiguration, first: int, steps: int, loaders: int
) -> Generator[B]:
    """The batches of steps ``first`` to ``steps - 1``.

    Each depends on seed and step only, not on the threads, nor on where the training began.

    Args:
        task: Prepares them.
        configuration: Batch size and seed.
        first: Step to begin with.
        steps: The number of steps of the whole training.
        loaders: Threads.
    """

    def prepare(step: int) -> B:
        randomness = np.random.default_rng([configuration.seed, step, 1])
        return task.batch(batch_indices(step, task.samples, configuration).tolist(), randomness)

    ready: deque[Future[B]] = deque()
    with ThreadPoolExecutor(loaders, thread_name_prefix="batches") as threads:
        try:
            for step in range(first, steps):
                while len(ready) < _AHEAD * loaders and step + len(ready) < steps:
                    ready.append(threads.submit(prepare, step + len(ready)))
                yield ready.popleft().result()
        finally:
            for future in ready:
                future.cancel()
