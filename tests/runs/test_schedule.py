"""Who does which cell, without any process."""

from __future__ import annotations

from collections import Counter, deque

import pytest

from avsec_gym.errors import DataError
from avsec_gym.runs.cell_worker import Done, Failed, Unready
from avsec_gym.runs.experiment import Cell
from avsec_gym.runs.schedule import CellQueue, Died, News, Ready, finished_cells


def cell(number: int, group: str = "") -> Cell:
    return Cell.of("a:b", group, number=number)


class Script:
    """Workers that answer in turn as a script says; who is not in it, is done."""

    def __init__(self, count: int, script: dict[int, list[Died | Failed | Unready]]) -> None:
        self.script, self.count = script, count
        self.given: deque[tuple[int, Cell]] = deque()
        self.history: list[tuple[int, int]] = []
        self.replaced: Counter[int] = Counter()
        self.starting = deque(range(count))

    def __len__(self) -> int:
        return self.count

    def give(self, number: int, cell: Cell) -> None:
        assert number not in [busy for busy, _ in self.given]
        self.given.append((number, cell))
        self.history.append((number, cell.arguments["number"]))

    def wait(self) -> list[tuple[int, News]]:
        if self.starting:
            return [(self.starting.popleft(), Ready())]
        number, cell = self.given.popleft()
        answers = self.script.get(cell.arguments["number"], [])
        return [(number, answers.pop(0) if answers else Done({}, 1.0))]

    def replace(self, number: int) -> None:
        self.replaced[number] += 1
        self.starting.append(number)

    def close(self) -> None: ...


class Slow(Script):
    """Only the first worker ever starts; whoever is replaced does not come back."""

    def __init__(self, count: int, script: dict[int, list[Died | Failed | Unready]]) -> None:
        super().__init__(count, script)
        self.starting = deque([0])

    def replace(self, number: int) -> None:
        self.replaced[number] += 1


KILLED = Died("was killed", at_work=True)
EARLY = Died("was killed", at_work=False)
LOST = Died("left with its machine", at_work=True, lost=True)
EARLY_LOST = Died("left with its machine", at_work=False, lost=True)


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
    # Now and then is no worker's fault.
    once = Script(1, {n: [EARLY] for n in range(6)})
    assert len(list(finished_cells([cell(n) for n in range(1)], once))) == 1
    always = Script(2, {n: [EARLY] * 9 for n in range(6)})
    with pytest.raises(DataError, match="before they have begun"):
        list(finished_cells([cell(n) for n in range(6)], always))


def test_who_has_not_started_gets_no_cell() -> None:
    workers = Slow(4, {2: [Failed("a slip")]})
    assert len(list(finished_cells([cell(n) for n in range(12)], workers))) == 12
    assert workers.history == [(0, n) for n in range(12)]


def test_a_cell_goes_to_whoever_is_free_when_its_worker_does_not_come_back() -> None:
    workers = Slow(2, {1: [KILLED]})
    workers.starting = deque([0, 1])
    # The first worker has nothing left to do when the second dies over the last cell.
    outcomes = dict(finished_cells([cell(0), cell(1)], workers))
    assert workers.history == [(0, 0), (1, 1), (0, 1)]
    assert all(isinstance(outcome, Done) for outcome in outcomes.values())


def test_a_cell_is_not_blamed_for_lost_machines_but_not_tried_for_ever() -> None:
    workers = Script(1, {0: [LOST] * 9, 1: [LOST] * 99, 2: [LOST, KILLED, LOST, KILLED]})
    outcomes = dict(finished_cells([cell(n) for n in range(3)], workers))
    assert isinstance(outcomes[cell(0)], Done)
    assert "left with its machine, 10 times" in outcomes[cell(1)].error  # type: ignore[union-attr]
    assert "was killed, twice" in outcomes[cell(2)].error  # type: ignore[union-attr]


def test_machines_lost_before_they_begin_stop_everything_in_the_end() -> None:
    few = Script(1, {0: [EARLY_LOST] * 9})
    assert len(list(finished_cells([cell(0)], few))) == 1
    with pytest.raises(DataError, match="left with its machine"):
        list(finished_cells([cell(0)], Script(1, {0: [EARLY_LOST] * 10})))


def test_idle_workers_may_die() -> None:
    class Fragile(Script):
        def wait(self) -> list[tuple[int, News]]:
            if len(self.history) == 2 and not self.replaced:
                return [(1, EARLY)]  # Before it was ever ready.
            return super().wait()

    workers = Fragile(2, {})
    workers.starting = deque([0])
    assert len(list(finished_cells([cell(n) for n in range(4)], workers))) == 4
    assert workers.replaced == {1: 1}


def test_a_work_that_cannot_be_made_stops_everything() -> None:
    workers = Script(2, {1: [Unready(DataError("no weights."))]})
    finished = finished_cells([cell(n) for n in range(6)], workers)
    assert next(finished)[0] == cell(0)
    with pytest.raises(DataError, match="no weights"):
        list(finished)
