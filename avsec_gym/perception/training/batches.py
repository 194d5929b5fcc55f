"""The batches of a training in their order, prepared ahead of time by threads or processes."""

from __future__ import annotations

import inspect
import pickle
from collections import deque
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avsec_gym.perception.training.configuration import TrainingConfiguration
from avsec_gym.perception.training.task import B, Prepared, Task
from avsec_gym.worker_processes import AVAILABLE, each_in_processes

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
    task: Task[B],
    configuration: TrainingConfiguration,
    first: int,
    steps: int,
    loaders: int,
    *,
    processes: bool = False,
    folder: Path = Path(),
) -> Generator[Prepared[B]]:
    """The batches of steps ``first`` to ``steps - 1``.

    Each depends on seed and step only, not on the threads, nor on where the training began.

    Args:
        task: The task that prepares them.
        configuration: Batch size and seed.
        first: Step to begin with.
        steps: The number of steps of the whole training.
        loaders: Threads or processes.
        processes: Whether to prepare in processes, if the task's ``batch`` can be sent to them:
            threads share Python with the steps, and a GPU waits for it.
        folder: The folder of the run, for errors.
    """
    prepare = partial(_prepare, task.batch, task.samples, configuration)
    if processes and AVAILABLE and not inspect.ismethod(task.batch):
        yield from _by_processes(prepare, range(first, steps), loaders, folder)
        return
    ready: deque[Future[Prepared[B]]] = deque()
    with ThreadPoolExecutor(loaders, thread_name_prefix="batches") as threads:
        try:
            for step in range(first, steps):
                while len(ready) < _AHEAD * loaders and step + len(ready) < steps:
                    ready.append(threads.submit(prepare, step + len(ready)))
                yield ready.popleft().result()
        finally:
            for future in ready:
                future.cancel()


def _prepare(
    batch: Callable[[Sequence[int], np.random.Generator], Prepared[B]],
    samples: int,
    configuration: TrainingConfiguration,
    step: int,
) -> Prepared[B]:
    randomness = np.random.default_rng([configuration.seed, step, 1])
    return batch(batch_indices(step, samples, configuration).tolist(), randomness)


def _by_processes(
    prepare: Callable[[int], Prepared[B]], steps: range, workers: int, folder: Path
) -> Generator[Prepared[B]]:
    making = partial(_pickling, prepare)
    made = each_in_processes(making, steps, workers, threads=1, folder=folder)
    early: dict[int, bytes] = {}

    def following(step: int) -> Prepared[B]:
        while step not in early:
            number, pickled = next(made)
            early[number] = pickled
        batch: Prepared[B] = pickle.loads(early.pop(step))
        return batch

    # A batch takes a while to arrive: it does while the step before is done.
    with closing(made), ThreadPoolExecutor(1, thread_name_prefix="batches") as receiver:
        coming = deque(receiver.submit(following, step) for step in steps[:_AHEAD])
        try:
            for step in steps:
                batch = coming.popleft().result()
                if step + _AHEAD in steps:
                    coming.append(receiver.submit(following, step + _AHEAD))
                yield batch
        finally:
            for future in coming:
                future.cancel()


def _pickling(prepare: Callable[[int], Prepared[B]]) -> Callable[[int], bytes]:
    # As bytes: torch would send tensors by files that only relatives of a process can open.
    return lambda step: pickle.dumps(prepare(step), pickle.HIGHEST_PROTOCOL)
