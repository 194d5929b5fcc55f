"""Where cells are done: one worker in each process, which keeps the works that it has made."""

from __future__ import annotations

import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass

from avsec_gym.errors import AvsecError, ConfigurationError
from avsec_gym.runs.catalogue import attribute
from avsec_gym.runs.experiment import Cell, CellResult, Configuration
from avsec_gym.runs.rows import Rows, rows_of


@dataclass(frozen=True, eq=False)
class Done:
    """A cell has a result."""

    rows: Rows
    seconds: float


@dataclass(frozen=True)
class Failed:
    """A cell ended in an error."""

    error: str
    """One line."""
    trace: str = ""
    seconds: float = 0.0


@dataclass(frozen=True)
class Unready:
    """The work of a cell cannot be made: weights are missing, say.  No cell of it can be done."""

    error: AvsecError


class CellWorker:
    """Does the cells of a run, one after the other.

    Args:
        configuration: The configuration of the run.
        threads: The threads of torch and OpenCV; other libraries take theirs from the environment.
    """

    def __init__(self, configuration: Configuration, threads: int) -> None:
        self._configuration = configuration
        self._threads = threads
        self._works: dict[str, Callable[..., CellResult]] = {}

    def prepare(self, cell: Cell) -> Unready | None:
        """Make the work of a cell, unless it is made already."""
        if cell.work in self._works:
            return None
        try:
            self._works[cell.work] = attribute(cell.work)(self._configuration)
        except AvsecError as error:
            return Unready(error)
        except Exception as error:
            return Unready(
                ConfigurationError(f"{cell.work} cannot be made: {error!r}\n{_trace(error)}")
            )
        # The last digits of a network's gradient depend on it.
        if "torch" in sys.modules:
            sys.modules["torch"].set_num_threads(self._threads)
        if "cv2" in sys.modules:
            sys.modules["cv2"].setNumThreads(self._threads)
        return None

    def do(self, cell: Cell) -> Done | Failed:
        """Do a cell whose work is prepared; whatever goes wrong in it becomes a failure."""
        begun = time.perf_counter()
        try:
            result = self._works[cell.work](**cell.arguments)
            seconds = time.perf_counter() - begun
            if not isinstance(result, CellResult):
                raise TypeError(f"a work returns a CellResult, got {type(result).__name__}")
            rows = rows_of(result)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # A cell that calls sys.exit has failed too.
            message = (
                str(error) if isinstance(error, AvsecError) else f"{type(error).__name__}: {error}"
            )
            return Failed(message, _trace(error), time.perf_counter() - begun)
        return Done(rows, seconds)


def _trace(error: BaseException) -> str:
    return "".join(traceback.format_exception(error))
