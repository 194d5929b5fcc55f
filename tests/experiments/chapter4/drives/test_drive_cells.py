"""A drive of the procedural world, from its instants to its section."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.experiments.chapter4.drives.drive_cells import ConnectedDrives
from avsec_gym.experiments.chapter4.drives.measured_window import (
    MeasuredWindow,
    measured_windows,
    within_box,
)
from avsec_gym.experiments.chapter4.drives.section import findings
from avsec_gym.experiments.chapter4.drives.settings import TOLERANCE, WINDOW
from avsec_gym.experiments.chapter4.settings import ATTACKS, CLEAN, FITTED, JUDGED
from avsec_gym.geometry import Floats
from avsec_gym.runs.catalogue import experiment
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import ReportRequest
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult
from tests.experiments.chapter4.known_run import Kept


@pytest.mark.slow
def test_a_drive_is_measured_and_shown(tmp_path: Path) -> None:
    small = Configuration("procedural", 1)
    done = run_experiments([experiment("chapter4_drives")], small, tmp_path / "run", workers=0)
    assert not done.failures
    run = RunFolder.open(tmp_path / "run")
    assert run.missing() == 0
    for part in (FITTED, JUDGED):
        [clean] = measured_windows(run, part, CLEAN)
        assert clean.lasted == WINDOW
        assert not clean.about.any()
        assert clean.scores.shape[1] == WINDOW
        attacked = [window for kind in ATTACKS for window in measured_windows(run, part, kind)]
        assert attacked
        # What can be decided is decided of a region about the attack.
        assert all(window.about.any() for window in attacked if window.decidable)
        assert all(window.covered for window in attacked if window.decidable)
        assert all(window.decidable <= window.lasted <= WINDOW for window in attacked)
    shown = findings(run, ReportRequest())
    assert shown.sections[0].tables[0].rows


@pytest.mark.slow
def test_windows_that_overlap_have_the_instants_of_one_drive(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []
    judged = ConnectedDrives._judged

    def counted(self: ConnectedDrives, instant: RecordedInstant) -> ConnectedResult:
        asked.append(instant.id)
        return judged(self, instant)

    monkeypatch.setattr(ConnectedDrives, "_judged", counted)
    measured = ConnectedDrives(Configuration("procedural", 1))
    rows = measured(FITTED, 0, windows=2, apart=1, attacked=False, format=0).measurements
    assert len(asked) == len(set(asked)) == WINDOW + 1
    first, second = measured_windows(Kept(rows), FITTED, CLEAN)  # type: ignore[arg-type]
    # What the nine common instants show is the same, whichever window they are in.
    for time in range(WINDOW - 1):
        np.testing.assert_array_equal(_at(first, time + 1), _at(second, time))


def _at(window: MeasuredWindow, time: int) -> Floats:
    scores = window.scores[:, time]
    return np.sort(scores[np.isfinite(scores)])


def test_what_is_about_an_attack_lies_in_its_grown_box() -> None:
    box = Regions(np.array([[10.0, 5.0, 0]]), np.array([[4.0, 2.0, 1.5]]), np.array([np.pi / 2]))
    beside = np.array([1.0, 1.0]) + TOLERANCE
    places = [(0.0, 1.99), (0.0, 0.0), (beside[0] + 0.01, 0.0), (0.0, beside[1] + 1.01)]
    centre = np.array([(10.0 + x, 5.0 + y, 0.0) for x, y in places])
    regions = Regions(centre, np.ones((4, 3)), np.zeros(4))
    assert within_box(regions, box).tolist() == [True, True, False, False]
