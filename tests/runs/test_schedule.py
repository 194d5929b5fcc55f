"""Who does which cell, without any process."""

from __future__ import annotations

from collections import Counter, deque

import pytest

from avsec_gym.errors import DataError
from avsec_gym.experiments.experiment import Cell
from avsec_gym.runs.desk import Done, Failed, Unready
from avsec_gym.runs.schedule import CellQueue, Died, finished_cells


def cell(number: int, group: str = "") -> Cell:
    return Cell.of("a:b", group, number=number)


class Script:
    """Workers that answer in turn as a script says; who is not in it, is done."""

    def __init__(self, count: int, script: dict[int, list[Died | Failed | Unready]]) -> None:
        self.script, self.count = script, count
        self.given: deque[tuple[int, Cell]] = deque()
        self.history: list[tuple[int, int]] = []
        self.replaced: Counter[int] = Counter()

    def __len__(self) -> int:
        return self.count

    def give(self, number: int, cell: Cell) -> None:
        assert number not in [busy for busy, _ in self.given]
        self.given.append((number, cell))
        self.history.append((number, cell.arguments["number"]))

    def wait(self) -> list[tuple[int, Done | Failed | Unready | Died]]:
        number, cell = self.given.popleft()
        answers = self.script.get(cell.arguments["number"], [])
        return [(number, answers.pop(0) if answers else Done({}, 1.0))]

    def replace(self, number: int) -> None:
        self.replaced[number] += 1

    def close(self) -> None: ...


KILLED = Died("was killed", at_work=True)
EARLY = Died("was killed", at_work=False)


def test_a_worker_stays_with_its_group_and_helps_in_the_end() -> None:
    queue = CellQueue([cell(n, "ab"[n % 2]) for n in range(6)])
    first, second = queue.take(), queue.take()
    assert first == cell(0)
    assert second == cell(1)
    assert queue.take("a") == cell(2)
    assert queue.take("a") == cell(4)
    assert queue.take("a") == cell(3)  # Nothing fresh is left.
    assert queue.take("b") == cell(5)
    assert queue.take("b") is None


def test_every_cell_is_done_once() -> None:
    cells = [cell(n, str(n // 3)) for n in range(10)]
    workers = Script(3, {})
    finished = [done for done, _ in finished_cells(cells, workers)]
    assert sorted(c.arguments["number"] for c in finished) == list(range(10))
    assert len(workers.history) == 10
    # The first group was done by one worker.
    assert {number for number, n in workers.history if n < 3} == {0}


def test_a_cell_whose_worker_dies_is_tried_once_more_in_the_end() -> None:
    workers = Script(1, {0: [KILLED], 1: [KILLED, KILLED]})
    outcomes = dict(finished_cells([cell(n) for n in range(4)], workers))
    assert [n for _, n in workers.history] == [0, 1, 2, 3, 0, 1]
    assert workers.replaced[0] == 3
    assert [type(outcomes[cell(n)]) for n in range(4)] == [Done, Failed, Done, Done]
    assert "was killed, twice" in outcomes[cell(1)].error  # type: ignore[union-attr]


def test_workers_that_die_before_they_begin_stop_everything() -> None:
    # Now and then is nobody's fault.
    once = Script(1, {n: [EARLY] for n in range(6)})
    assert len(list(finished_cells([cell(n) for n in range(1)], once))) == 1
    always = Script(2, {n: [EARLY] * 9 for n in range(6)})
    with pytest.raises(DataError, match="before they have begun"):
        list(finished_cells([cell(n) for n in range(6)], always))


def test_a_work_that_cannot_be_made_stops_everything() -> None:
    workers = Script(2, {1: [Unready(DataError("no weights."))]})
    finished = finished_cells([cell(n) for n in range(6)], workers)
    assert next(finished)[0] == cell(0)
    with pytest.raises(DataError, match="no weights"):
        list(finished)
