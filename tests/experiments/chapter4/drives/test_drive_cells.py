"""A drive of the procedural world, from its instants to its section."""

from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.experiments.chapter4.drives.section import findings
from avsec_gym.experiments.chapter4.drives.settings import GHOST, WINDOW
from avsec_gym.experiments.chapter4.drives.window_rates import drive_windows
from avsec_gym.experiments.chapter4.settings import CLEAN, FITTED, JUDGED
from avsec_gym.runs.catalogue import experiment
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import ReportRequest


@pytest.mark.slow
def test_a_drive_is_measured_and_shown(tmp_path: Path) -> None:
    small = Configuration("procedural", 1)
    done = run_experiments([experiment("chapter4_drives")], small, tmp_path / "run", workers=0)
    assert not done.failures
    run = RunFolder.open(tmp_path / "run")
    assert run.missing() == 0
    for part in (FITTED, JUDGED):
        windows = drive_windows(run, part, CLEAN)
        assert len(windows) == 1
        assert windows.scores["rays"][0].shape == (WINDOW,)
    ghosts = drive_windows(run, JUDGED, GHOST)
    assert len(ghosts) <= 1
    shown = findings(run, ReportRequest())
    assert shown.sections[0].tables[0].rows
