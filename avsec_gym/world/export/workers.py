"""Frames made by several processes; what comes out does not depend on how many."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Sequence
from functools import partial
from pathlib import Path

from avsec_gym.worker_processes import each_in_processes
from avsec_gym.world.export.recipe import Recipe


def usual_workers() -> int:
    """Two, or as many as there are processors."""
    return min(2, os.cpu_count() or 1)


def make_frames(
    recipe: Recipe, root: Path, numbers: Sequence[int], workers: int
) -> Generator[tuple[int, list[str]], None, None]:
    """Make frames; yields each number with its remarks when the frame is there.

    Args:
        recipe: The recipe of the data set.
        root: The folder.
        numbers: Numbers of the frames to make.
        workers: Number of processes; with 1, the calling process does the work.

    Raises:
        DataError: A file cannot be written, or a worker died.
    """
    if workers == 1 or len(numbers) == 1:
        yield from ((number, _make(recipe, root, number)) for number in numbers)
        return
    making = partial(_making, recipe, root)
    yield from each_in_processes(making, numbers, workers, threads=1, folder=root)


def _making(recipe: Recipe, root: Path) -> Callable[[int], list[str]]:
    return partial(_make, recipe, root)


def _make(recipe: Recipe, root: Path, number: int) -> list[str]:
    import cv2

    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        return recipe.make(root, number)
    finally:
        cv2.setNumThreads(threads)
