"""Who does which cell when, and what happens when a worker dies over one."""

from __future__ import annotations

import logging
from collections import Counter, deque
from collections.abc import Generator, Iterable
from dataclasses import dataclass
from typing import Protocol

from avsec_gym.errors import DataError
from avsec_gym.runs.cell_worker import Done, Failed, Unready
from avsec_gym.runs.experiment import Cell

_LOG = logging.getLogger(__name__)
_DEATHS = 2
"""So many workers may die over a cell before the cell has failed."""
_EARLY_DEATHS = 3
"""So many workers may die in a row before they have begun a cell."""
_LOSSES = 10
"""So many workers may be lost over a cell, or in a row before they have begun one."""


@dataclass(frozen=True)
class Ready:
    """A worker has started and answers: it may be given a cell."""


@dataclass(frozen=True)
class Died:
    """A worker is gone, and what it did with it."""

    how: str
    """Such as ``was killed by SIGKILL``."""
    at_work: bool
    """Whether it was at work on the cell; else it had none, or was still making the cell's work."""
    lost: bool = False
    """Whether it was lost with its machine, or the way to it: no fault of the cell."""


News = Ready | Done | Failed | Unready | Died
"""What is heard of a worker."""


class Workers(Protocol):
    """Some processes that do one cell each at a time, numbered from 0."""

    def __len__(self) -> int:
        """How many."""
        ...

    def give(self, number: int, cell: Cell) -> None:
        """Let a worker do a cell; it is ready, and has none in hand."""
        ...

    def wait(self) -> list[tuple[int, News]]:
        """Who is ready, and what became of the cells in hand; waits for news of one at least.

        Raises:
            ConfigurationError: No worker does anything, and none becomes ready.
        """
        ...

    def replace(self, number: int) -> None:
        """Start a new worker in the place of one that died; `wait` reports when it is ready."""
        ...

    def close(self) -> None:
        """End all of them, and what they have in hand."""
        ...


def finished_cells(
    cells: Iterable[Cell], workers: Workers
) -> Generator[tuple[Cell, Done | Failed], None, None]:
    """Have cells done; yields them as they are finished.

    Only a worker that is ready gets a cell, so that one that never starts holds nothing up. A cell
    whose worker dies is tried again, in the end, by whoever is free.

    Args:
        cells: The cells, each once.
        workers: The workers that do them; left open.

    Raises:
        AvsecError: The work of a cell cannot be made.
        ConfigurationError: No worker starts.
        DataError: Workers die before they begin.
    """
    queue = CellQueue(cells)
    in_hand: dict[int, Cell] = {}
    idle: list[int] = []
    early = _EarlyDeaths()
    deaths: Counter[Cell] = Counter()
    losses: Counter[Cell] = Counter()

    def hand_out(number: int, group: str = "") -> None:
        if (cell := queue.take(group)) is None:
            idle.append(number)
        else:
            in_hand[number] = cell
            workers.give(number, cell)

    # Invariant: each cell is in the queue, in one worker's hand, or was yielded.
    while queue or in_hand:
        for number, news in workers.wait():
            if isinstance(news, Ready):
                hand_out(number)
                continue
            if isinstance(news, Unready):
                raise news.error
            cell = in_hand.pop(number, None)
            # A new worker takes the dead one's place; its cell is tried again, but not for ever.
            if isinstance(news, Died):
                over = "nothing" if cell is None else f"{cell.work} {cell.key}"
                _LOG.warning("a worker %s over %s", news.how, over)
                early.note(news)
                workers.replace(number)
                if cell is None:
                    continue
                deaths[cell] += news.at_work and not news.lost
                losses[cell] += news.at_work and news.lost
                if deaths[cell] < _DEATHS and losses[cell] < _LOSSES:
                    queue.put_back(cell)
                    if idle:  # Else its turn comes when a worker is ready, or done.
                        hand_out(idle.pop())
                    continue
                often = f"{losses[cell]} times" if deaths[cell] < _DEATHS else "twice"
                yield cell, Failed(f"The process that did it {news.how}, {often}.")
                continue
            assert cell is not None, "only a worker that was given a cell has a result"
            early.forget()
            hand_out(number, cell.group)  # First, so that no worker waits while results are stored.
            yield cell, news


class _EarlyDeaths:
    """Workers that died in a row before they had begun a cell: too many end the run."""

    def __init__(self) -> None:
        self._by_themselves = self._lost = 0

    def forget(self) -> None:
        self._by_themselves = self._lost = 0

    def note(self, death: Died) -> None:
        if death.at_work:
            self.forget()
            return
        self._lost += death.lost
        self._by_themselves += not death.lost
        if self._by_themselves == _EARLY_DEATHS or self._lost == _LOSSES:
            raise DataError(
                f"Workers die before they have begun: the last one {death.how}.",
                remedy="Is the memory full? Fewer --workers take less.",
            )


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

    def __bool__(self) -> bool:
        """Whether any cell waits."""
        return bool(self._groups)

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
