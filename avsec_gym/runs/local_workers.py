"""Workers that are processes of this machine."""

from __future__ import annotations

import logging
import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path

from avsec_gym.experiments.experiment import Cell, Configuration
from avsec_gym.runs.desk import Desk, Done, Failed, Unready
from avsec_gym.runs.schedule import Died

LOG_FORMAT = "%(asctime)s %(levelname)s %(name)s: %(message)s"
"""Of ``run.log``, which several processes write."""

THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""Libraries read them when they are loaded."""

_SECONDS_TO_LEAVE = 5.0


class LocalWorkers:
    """Fresh processes (spawned, not forked), each with its desk.

    They leave when this process dies, whatever kills it.

    Args:
        configuration: Of the run.
        count: Processes.
        threads: Of each.
        log: File that takes their warnings.
    """

    def __init__(self, configuration: Configuration, count: int, threads: int, log: Path) -> None:
        self._arguments = (configuration, threads, log)
        self._variables = dict.fromkeys(THREAD_VARIABLES, str(threads))
        self._workers = [self._start() for _ in range(count)]
        self._busy: set[int] = set()
        self._at_work: set[int] = set()

    def __len__(self) -> int:
        return len(self._workers)

    def give(self, number: int, cell: Cell) -> None:
        """Let a worker do a cell."""
        self._busy.add(number)
        with suppress(OSError):  # It has died; `wait` will tell.
            self._workers[number][1].send(cell)

    def wait(self) -> list[tuple[int, Done | Failed | Unready | Died]]:
        """What came of cells in hand, or of those who had them."""
        outcomes: list[tuple[int, Done | Failed | Unready | Died]] = []
        while not outcomes:
            ends = [self._workers[number][1] for number in self._busy]
            sentinels = [self._workers[number][0].sentinel for number in self._busy]
            ready = wait([*ends, *sentinels])
            for number in sorted(self._busy):
                process, connection = self._workers[number]
                if connection in ready or process.sentinel in ready:
                    outcomes += [(number, outcome) for outcome in self._heard(number)]
        for number, _ in outcomes:
            self._busy.discard(number)
            self._at_work.discard(number)
        return outcomes

    def replace(self, number: int) -> None:
        """A new process for one that died."""
        self._workers[number][1].close()
        self._workers[number] = self._start()

    def close(self) -> None:
        """End all of them; at once those that have something in hand."""
        for number, (process, connection) in enumerate(self._workers):
            connection.close()
            if number in self._busy:
                process.kill()
        for process, _ in self._workers:
            process.join(_SECONDS_TO_LEAVE)
            if process.is_alive():
                process.kill()
                process.join()

    def _heard(self, number: int) -> Iterator[Done | Failed | Unready | Died]:
        """What a worker said last; nothing if it only said that it begins."""
        process, connection = self._workers[number]
        try:
            # What it said before it died still counts.
            while connection.poll():
                if (said := connection.recv()) is not None:
                    yield said
                    return
                self._at_work.add(number)
            if process.is_alive():
                return
        except (EOFError, OSError):
            pass
        process.join(1.0)
        process.kill()
        process.join()
        yield Died(_how_it_ended(process.exitcode), number in self._at_work)

    def _start(self) -> tuple[SpawnProcess, Connection]:
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, *self._arguments))
        with _environment(self._variables):
            process.start()
        theirs.close()
        return process, ours


def _serve(connection: Connection, configuration: Configuration, threads: int, log: Path) -> None:
    """A worker's life: leaves Ctrl-C to its parent, and ends when nobody listens any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with_parent, daemon=True).start()
    logging.basicConfig(filename=log, format=LOG_FORMAT, level=logging.WARNING)
    logging.captureWarnings(True)
    desk = Desk(configuration, threads)
    while True:
        try:
            cell = connection.recv()
        except (EOFError, OSError):
            return
        outcome: Done | Failed | Unready | None = desk.prepare(cell)
        if outcome is None:
            connection.send(None)  # "I begin": if it dies now, it is the cell that kills.
            outcome = desk.do(cell)
        try:
            connection.send(outcome)
        except (pickle.PicklingError, TypeError, AttributeError, ValueError) as error:
            connection.send(Failed(f"Its result cannot be sent: {error}"))


def _leave_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "workers are children"
    parent.join()
    os._exit(1)


def _how_it_ended(code: int | None) -> str:
    if code is not None and code < 0:
        return f"was killed by signal {-code} ({signal.strsignal(-code)})"
    return f"left with exit code {code}"


@contextmanager
def _environment(variables: dict[str, str]) -> Iterator[None]:
    """For the new process, not for this one, which has loaded its libraries."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
