"""Frames made by several processes; what comes out does not depend on how many."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import Connection
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
) -> Generator[tuple[int, list[str]], None, None]:
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
    context = multiprocessing.get_context("spawn")
    lifeline, end = context.Pipe(duplex=False)
    with _one_thread_each():
        pool = ProcessPoolExecutor(min(workers, len(numbers)), context, _begin, (lifeline,))
        try:
            waiting: dict[Future[list[str]], int] = {}
            for number in numbers:
                waiting[pool.submit(_make, recipe, root, number)] = number
                if len(waiting) > workers:
                    yield from _finished(waiting)
            while waiting:
                yield from _finished(waiting)
        except BaseException as error:
            # What the workers have in hand is made anew another time.
            end.close()
            if not isinstance(error, BrokenProcessPool):
                raise
            raise DataError(
                "A worker process ended before its work.",
                path=root,
                remedy="Was it killed, or is the memory full? With fewer --workers it takes less;"
                " run the command again to go on.",
            ) from error
        finally:
            pool.shutdown(cancel_futures=True)
            end.close()
            lifeline.close()


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


def _begin(lifeline: Connection) -> None:
    """A worker leaves Ctrl-C to its parent, and ends at once when the other end is closed.

    The system closes it when the parent dies.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def leave() -> None:
        wait_for([lifeline])
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
