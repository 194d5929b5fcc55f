"""Processes that do cells: how many threads they have, and what their death does."""

from __future__ import annotations

import os
import time
from pathlib import Path
from types import ModuleType

import pytest

from avsec_gym.errors import DataError
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.local_workers import LocalWorkers
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.worker_processes import THREAD_VARIABLES

SMALL = Configuration(limit=4)


@pytest.mark.slow
def test_a_worker_that_dies_is_replaced_and_its_cell_fails_at_the_second_death(
    tiny: ModuleType, diary: Path, tmp_path: Path
) -> None:
    experiment = tiny.trouble("fine", "leave", "killed", "killed once", "bug", "fine")
    report = run_experiments([experiment], SMALL, tmp_path / "run", workers=1, threads=1)
    errors = {cell.arguments["what"]: error for cell, error in report.failures}
    assert errors == {
        "leave": "The process that did it left with exit code 7, twice.",
        "killed": "The process that did it was killed by signal 9 (Killed), twice.",
        "bug": "ZeroDivisionError: a slip",
    }
    begun = [line.rpartition(" ")[0] for line in diary.read_text().splitlines()]
    assert [begun.count(f"{n} {what}") for n, what in enumerate(
        ["fine", "leave", "killed", "killed once", "bug", "fine"]
    )] == [1, 2, 2, 2, 1, 1]  # fmt: skip
    log = (tmp_path / "run/run.log").read_text()
    assert log.count("a worker was killed by signal 9") == 3


@pytest.mark.slow
def test_rows_do_not_depend_on_the_processes(tiny: ModuleType, tmp_path: Path) -> None:
    for workers in (0, 1, 2):
        root = tmp_path / str(workers)
        run_experiments([tiny.PRECISION, tiny.SAFETY], SMALL, root, workers=workers, threads=1)
    here, one, two = (RunFolder.open(tmp_path / name) for name in "012")
    # What is not a number is like itself as text alone.
    assert repr(here.episodes()) == repr(one.episodes()) == repr(two.episodes())
    assert here.measurements() == one.measurements() == two.measurements()
    assert len(here.episodes()) == 4 * 3 * 2


@pytest.mark.slow
def test_threads_are_those_asked_for(tiny: ModuleType, tmp_path: Path) -> None:
    before = [os.environ.get(name) for name in THREAD_VARIABLES]
    run_experiments([tiny.only("Threads", 3)], SMALL, tmp_path / "run", workers=1, threads=3)
    assert [os.environ.get(name) for name in THREAD_VARIABLES] == before
    run = RunFolder.open(tmp_path / "run")
    assert {row.value for row in run.measurements(name="torch")} == {3.0}
    assert {row.value for row in run.measurements(name="blas")} == {3.0}
    processes = {row.value for row in run.measurements(name="process")}
    assert len(processes) == 1, "a work is made once in a process"
    assert os.getpid() not in processes


@pytest.mark.slow
def test_works_that_cannot_be_made_or_kill_stop_the_run(tiny: ModuleType, tmp_path: Path) -> None:
    for place, told in (("no_work", "no weights"), ("deadly_work", "before they have begun")):
        with pytest.raises(DataError, match=told):
            run_experiments([tiny.only(place, 4)], SMALL, tmp_path / place, workers=1)
        assert RunFolder.open(tmp_path / place).missing() == 4


@pytest.mark.slow
def test_workers_leave_at_once_when_they_are_closed(
    tiny: ModuleType, diary: Path, tmp_path: Path
) -> None:
    slow = Configuration(options={"pause": 60.0})
    cells = tiny.PRECISION.cells(Configuration(limit=1))
    workers = LocalWorkers(slow, 2, 1, tmp_path / "log")
    workers.give(0, cells[0])
    while not diary.read_text():
        time.sleep(0.02)
    begun = time.monotonic()
    workers.close()
    assert time.monotonic() - begun < 4.0
    process = int(diary.read_text().split()[-1])
    assert not Path(f"/proc/{process}").exists()


@pytest.mark.slow
def test_a_stopped_run_leaves_no_process(tiny: ModuleType, diary: Path, tmp_path: Path) -> None:
    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_experiments([tiny.PRECISION], SMALL, tmp_path / "run", workers=1, on_progress=stop)
    assert not Path(f"/proc/{diary.read_text().split()[-1]}").exists()
    assert len(RunFolder.open(tmp_path / "run").cells()) == 1


@pytest.mark.slow
def test_warnings_of_workers_are_in_the_log(tiny: ModuleType, tmp_path: Path) -> None:
    run_experiments([tiny.trouble("warning")], SMALL, tmp_path / "run", workers=1)
    assert "something is odd" in (tmp_path / "run/run.log").read_text()
