"""Frames made by several processes; what comes out does not depend on how many."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import wait as wait_for
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.world.export.recipe import Recipe

_ONE_THREAD = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)


def usual_workers() -> int:
    """Two, or as many as there are processors."""
    return min(2, os.cpu_count() or 1)


def make_frames(
    recipe: Recipe, root: Path, numbers: Sequence[int], workers: int
) -> Iterator[tuple[int, list[str]]]:
    """Make frames; yields each number with its remarks when the frame is there.

    Args:
        recipe: Of the data set.
        root: Its folder.
        numbers: Which frames.
        workers: Processes; with 1, this very one does it.

    Raises:
        DataError: A file cannot be written, or a worker died.
    """
    if workers == 1 or len(numbers) == 1:
        yield from ((number, _make(recipe, root, number)) for number in numbers)
        return
    with _one_thread_each():
        pool = ProcessPoolExecutor(
            min(workers, len(numbers)), multiprocessing.get_context("spawn"), _begin
        )
        try:
            # Few are handed out at a time, so that little is left to finish when it is stopped.
            rest = iter(numbers)
            waiting: dict[Future[list[str]], int] = {}
            for number in rest:
                waiting[pool.submit(_make, recipe, root, number)] = number
                if len(waiting) > workers:
                    yield from _finished(waiting)
            while waiting:
                yield from _finished(waiting)
        except BrokenProcessPool as error:
            raise DataError(
                "A worker process ended before its work.",
                path=root,
                remedy="Was it killed, or is the memory full? With fewer --workers it takes less;"
                " run the command again to go on.",
            ) from error
        finally:
            pool.shutdown(cancel_futures=True)


def _finished(waiting: dict[Future[list[str]], int]) -> Iterator[tuple[int, list[str]]]:
    for future in wait(waiting, return_when=FIRST_COMPLETED).done:
        yield waiting.pop(future), future.result()


def _make(recipe: Recipe, root: Path, number: int) -> list[str]:
    import cv2

    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        return recipe.make(root, number)
    finally:
        cv2.setNumThreads(threads)


def _begin() -> None:
    """A worker leaves Ctrl-C to its parent, and does not outlive it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None, "this runs in a worker"

    def leave() -> None:
        wait_for([parent.sentinel])
        os._exit(1)

    threading.Thread(target=leave, daemon=True).start()


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Libraries read these when they are loaded: in the new processes, not in this one."""
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
