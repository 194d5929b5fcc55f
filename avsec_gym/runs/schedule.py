"""Who does which cell when, and what happens when a worker dies over one."""

from __future__ import annotations

import logging
from collections import Counter, deque
from collections.abc import Generator, Iterable
from dataclasses import dataclass
from typing import Protocol

from avsec_gym.errors import DataError
from avsec_gym.experiments.experiment import Cell
from avsec_gym.runs.desk import Done, Failed, Unready

_LOG = logging.getLogger(__name__)
_EARLY_DEATHS = 3
"""So many workers may die in a row before they have begun a cell."""


@dataclass(frozen=True)
class Died:
    """A worker is gone, and what it did with it."""

    how: str
    """Such as ``was killed by SIGKILL``."""
    at_work: bool
    """On the cell; else it was still making the cell's work."""


class Workers(Protocol):
    """Some processes that do one cell each at a time, numbered from 0."""

    def __len__(self) -> int:
        """How many."""
        ...

    def give(self, number: int, cell: Cell) -> None:
        """Let a worker do a cell; it has none in hand."""
        ...

    def wait(self) -> list[tuple[int, Done | Failed | Unready | Died]]:
        """What became of the cells in hand of some workers, at least one; waits for it."""
        ...

    def replace(self, number: int) -> None:
        """Put a new worker in the place of one that died."""
        ...

    def close(self) -> None:
        """End all of them, and what they have in hand."""
        ...


def finished_cells(
    cells: Iterable[Cell], workers: Workers
) -> Generator[tuple[Cell, Done | Failed], None, None]:
    """Have cells done; yields them as they are finished.

    A cell whose worker dies is tried once more, in the end, by another worker.

    Args:
        cells: Each once.
        workers: Who do them; left open.

    Raises:
        AvsecError: The work of a cell cannot be made.
        DataError: Workers die before they begin.
    """
    queue = CellQueue(cells)
    in_hand: dict[int, Cell] = {}
    deaths: Counter[Cell] = Counter()
    early_deaths = 0

    def hand_out(number: int, group: str = "") -> None:
        if (cell := queue.take(group)) is not None:
            in_hand[number] = cell
            workers.give(number, cell)

    for number in range(len(workers)):
        hand_out(number)
    while in_hand:
        for number, outcome in workers.wait():
            cell = in_hand.pop(number)
            if isinstance(outcome, Unready):
                raise outcome.error
            if isinstance(outcome, Died):
                _LOG.warning("a worker %s over %s %s", outcome.how, cell.work, cell.key)
                early_deaths = 0 if outcome.at_work else early_deaths + 1
                if early_deaths == _EARLY_DEATHS:
                    raise DataError(
                        f"Workers die before they have begun: the last one {outcome.how}.",
                        remedy="Is the memory full? Fewer --workers take less.",
                    )
                deaths[cell] += outcome.at_work
                workers.replace(number)
                if deaths[cell] < 2:
                    queue.put_back(cell)
                    hand_out(number)
                    continue
                outcome = Failed(f"The process that did it {outcome.how}, twice.")
            else:
                early_deaths = 0
            hand_out(number, cell.group)  # First, so that nobody waits while results are stored.
            yield cell, outcome


class CellQueue:
    """Cells that wait, group by group.

    A worker stays with a group until nothing of it waits, so that what a group shares is loaded
    once; only when no fresh group is left do several workers share one.
    """

    def __init__(self, cells: Iterable[Cell]) -> None:
        self._groups: dict[str, deque[Cell]] = {}
        self._begun: set[str] = set()
        for cell in cells:
            self._groups.setdefault(_group(cell), deque()).append(cell)

    def take(self, group: str = "") -> Cell | None:
        """The next cell of a group, or of another one; None where no cell waits."""
        if group not in self._groups:
            if not self._groups:
                return None
            fresh = (name for name in self._groups if name not in self._begun)
            group = next(fresh, "") or max(self._groups, key=lambda name: len(self._groups[name]))
        self._begun.add(group)
        cell = self._groups[group].popleft()
        if not self._groups[group]:
            del self._groups[group]
        return cell

    def put_back(self, cell: Cell) -> None:
        """Let a cell wait once more, behind all others."""
        self._groups.setdefault(f"again {cell.id}", deque()).append(cell)


def _group(cell: Cell) -> str:
    return cell.group or cell.id
