"""The one worker that is no process of its own: for debuggers, and for cells of milliseconds."""

from __future__ import annotations

from avsec_gym.runs.cell_worker import CellWorker
from avsec_gym.runs.experiment import Cell, Configuration
from avsec_gym.runs.schedule import News, Ready


class ThisProcess:
    """Does cells right here; a cell that kills its process kills the run, which can be resumed.

    Args:
        configuration: The configuration of the run.
        threads: The number of threads of torch and OpenCV, from now on.
    """

    def __init__(self, configuration: Configuration, threads: int) -> None:
        self._worker = CellWorker(configuration, threads)
        self._in_hand: list[Cell] = []

    def __len__(self) -> int:
        return 1

    def give(self, number: int, cell: Cell) -> None:
        """Take a cell in hand."""
        self._in_hand.append(cell)

    def wait(self) -> list[tuple[int, News]]:
        """Do it, if there is one."""
        if not self._in_hand:
            return [(0, Ready())]
        cell = self._in_hand.pop()
        return [(0, self._worker.prepare(cell) or self._worker.do(cell))]

    def replace(self, number: int) -> None:
        """Nothing to do: this process has not died."""

    def close(self) -> None:
        """Nothing to do: no process is to be ended."""
