"""The log of a run on a disk without room, or where it cannot be written."""

from __future__ import annotations

import os
from pathlib import Path
from types import ModuleType

import pytest

from avsec_gym.errors import DataError
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.run_log import JOURNAL, log_into

FULL = Path("/dev/full")
needs_it = pytest.mark.skipif(not FULL.exists(), reason="needs a device that is always full")


@needs_it
def test_a_full_disk_makes_no_noise(capfd: pytest.CaptureFixture[str]) -> None:
    with log_into(FULL):
        for _ in range(3):
            JOURNAL.info("a line")
    assert capfd.readouterr() == ("", "")


@needs_it
@pytest.mark.parametrize("workers", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_rows_are_kept_without_a_log(
    workers: int, tiny: ModuleType, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    failing = tiny.trouble("fine", "bug")
    run_experiments([failing], Configuration(), tmp_path, workers=workers, threads=1)
    log = tmp_path / "run.log"
    log.unlink()
    log.symlink_to(FULL)
    report = run_experiments(
        [failing], Configuration(), tmp_path, workers=workers, threads=1, retry=True
    )
    assert len(report.failures) == 1
    assert {cell.status for cell in RunFolder.open(tmp_path).cells()} == {"done", "failed"}
    assert "Traceback" not in capfd.readouterr().err


def test_a_folder_in_its_place_is_named(tmp_path: Path) -> None:
    (tmp_path / "run.log").mkdir()
    refused = pytest.raises(DataError, match=r"run\.log: The log cannot be written")
    with refused, log_into(tmp_path / "run.log"):
        pass


def test_a_pipe_in_its_place_does_not_block(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "run.log")
    with pytest.raises(DataError, match="a pipe"), log_into(tmp_path / "run.log"):
        pass
