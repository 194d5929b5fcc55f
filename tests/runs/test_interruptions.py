"""Killed at random times and started again, a run comes to the same rows."""

from __future__ import annotations

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder

PROGRAM = """
import sys
from pathlib import Path
import tiny_experiments as tiny
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.run import run_experiments

if __name__ == "__main__":
    root, workers = Path(sys.argv[1]), int(sys.argv[2])
    asked = Configuration(limit=15, seed=3, options={"pause": 0.06})
    run_experiments([tiny.PRECISION, tiny.SAFETY], asked, root, workers=workers, threads=1)
"""
CELLS, KILLS = 45, 3
Rows = Callable[[Path], dict[str, list[tuple[Any, ...]]]]


def begin(folder: Path, root: Path, workers: int) -> subprocess.Popen[bytes]:
    program = folder / "program.py"
    program.write_text(PROGRAM)
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parent)}
    return subprocess.Popen(
        [sys.executable, str(program), str(root), str(workers)], env=environment
    )


def finished(root: Path) -> int:
    try:
        with sqlite3.connect(f"file:{root}/results.sqlite?mode=ro", uri=True) as database:
            return int(database.execute("SELECT count(*) FROM cells").fetchone()[0])
    except sqlite3.Error:
        return 0  # Not there yet.


def gone(process: int) -> bool:
    return not Path(f"/proc/{process}").exists()


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_killed_at_random_times(
    tiny: ModuleType, diary: Path, tmp_path: Path, rows: Rows, workers: int
) -> None:
    """SIGKILL, three times: once while the run begins, then wherever it is."""
    without_pauses = Configuration(limit=15, seed=3)
    undisturbed = tmp_path / "undisturbed"
    run_experiments(
        [tiny.PRECISION, tiny.SAFETY], without_pauses, undisturbed, workers=0, threads=1
    )
    expected = rows(undisturbed)
    assert len(expected["cells"]) == CELLS == len(diary.read_text().splitlines())
    diary.write_text("")
    root, chance = tmp_path / "killed", random.Random(workers)
    for kill in range(KILLS):
        before = finished(root)
        run = begin(tmp_path, root, workers)
        if kill:
            while finished(root) == before and run.poll() is None:
                time.sleep(0.005)
        time.sleep(chance.uniform(0.0, 0.4 if kill else 1.5))
        run.send_signal(signal.SIGKILL)
        assert run.wait() == -signal.SIGKILL, "slower cells, please: it was done before it died"
        there = rows(root)["cells"] if finished(root) else []
        assert set(there) <= set(expected["cells"])
    assert 0 < finished(root) < CELLS
    assert begin(tmp_path, root, workers).wait() == 0
    assert rows(root) == expected
    # Nothing finished was done again: at most the cells in hand at each kill.
    begun = [line.split() for line in diary.read_text().splitlines()]
    assert CELLS <= len(begun) <= CELLS + KILLS * workers
    # The orphans have left.
    processes = {int(words[-1]) for words in begun}
    assert len(processes) > workers
    deadline = time.monotonic() + 5.0
    while not all(map(gone, processes)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert all(map(gone, processes))
    assert RunFolder.open(root).missing() == 0
