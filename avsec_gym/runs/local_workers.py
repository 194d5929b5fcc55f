"""Workers that are processes of this machine."""

from __future__ import annotations

import logging
import pickle
from collections.abc import Iterator
from multiprocessing.connection import Connection
from pathlib import Path

from avsec_gym.runs.cell_worker import CellWorker, Done, Failed, Unready
from avsec_gym.runs.experiment import Cell, Configuration
from avsec_gym.runs.run_log import LogFile
from avsec_gym.runs.schedule import Died, News, Ready
from avsec_gym.worker_processes import Worker, wait_for


class LocalWorkers:
    """Fresh processes, each with its `CellWorker`.

    They leave when this process dies, whatever kills it.

    Args:
        configuration: The configuration of the run.
        count: The number of processes.
        threads: The number of threads of each.
        log: File that takes their warnings.
    """

    def __init__(self, configuration: Configuration, count: int, threads: int, log: Path) -> None:
        self._arguments = (configuration, threads, log)
        self._workers = [self._start() for _ in range(count)]
        self._new = list(range(count))
        self._busy: set[int] = set()
        self._at_work: set[int] = set()

    def __len__(self) -> int:
        return len(self._workers)

    def give(self, number: int, cell: Cell) -> None:
        """Let a worker do a cell."""
        self._busy.add(number)
        self._workers[number].send(cell)

    def wait(self) -> list[tuple[int, News]]:
        """Who is new, else what came of cells in hand, or of those who had them."""
        if self._new:  # A cell may wait in the pipe while its process starts.
            new, self._new = self._new, []
            return [(number, Ready()) for number in new]
        outcomes: list[tuple[int, News]] = []
        while not outcomes:
            heard = wait_for([self._workers[number] for number in self._busy])
            for number in sorted(self._busy):
                if self._workers[number] in heard:
                    outcomes += [(number, outcome) for outcome in self._heard(number)]
        for number, _ in outcomes:
            self._busy.discard(number)
            self._at_work.discard(number)
        return outcomes

    def replace(self, number: int) -> None:
        """A new process for one that died."""
        self._workers[number] = self._start()
        self._new.append(number)

    def close(self) -> None:
        """End all of them; at once those that have something in hand."""
        for number, worker in enumerate(self._workers):
            worker.dismiss(at_once=number in self._busy)
        for worker in self._workers:
            worker.join()

    def _heard(self, number: int) -> Iterator[Done | Failed | Unready | Died]:
        """The last news of a worker; none if it only reported that it begins."""
        worker = self._workers[number]
        try:
            # What it reported before it died still counts.
            while worker.said_something():
                if (said := worker.receive()) is not None:
                    yield said
                    return
                self._at_work.add(number)
            if not worker.has_left():
                return
        except EOFError:
            pass
        yield Died(worker.how_it_ended(), number in self._at_work)

    def _start(self) -> Worker:
        return Worker(_serve, *self._arguments, threads=self._arguments[1])


def _serve(connection: Connection, configuration: Configuration, threads: int, log: Path) -> None:
    """Do the cells that a worker process is given, until the connection ends."""
    logging.basicConfig(handlers=[LogFile(log)], level=logging.WARNING)
    logging.captureWarnings(True)
    worker = CellWorker(configuration, threads)
    while True:
        try:
            cell = connection.recv()
        except (EOFError, OSError):
            return
        outcome: Done | Failed | Unready | None = worker.prepare(cell)
        if outcome is None:
            connection.send(None)  # "I begin": if it dies now, it is the cell that kills.
            outcome = worker.do(cell)
        try:
            connection.send(outcome)
        except (pickle.PicklingError, TypeError, AttributeError, ValueError) as error:
            connection.send(Failed(f"Its result cannot be sent: {error}"))
