"""Rates over windows, from runs in which the scores are simulated."""

from __future__ import annotations

import json

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter4.drives.drive_cells import drive_cells, drive_inputs
from avsec_gym.experiments.chapter4.drives.section import drives_section
from avsec_gym.experiments.chapter4.drives.settings import (
    DRIVE_METHODS,
    GHOST,
    WINDOW,
    drive_setting,
)
from avsec_gym.experiments.chapter4.drives.window_rates import (
    DrivesSummary,
    drive_windows,
    drives_summary,
)
from avsec_gym.experiments.chapter4.settings import CLEAN, FITTED, JUDGED, Part, State
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.metrics.tolerance import rate_bound
from avsec_gym.runs.experiment import Configuration, Measurement
from tests.experiments.chapter4.known_run import Kept

_DRIVES, _WINDOWS = 300, 2


def _rows(part: Part, state: State, scores: np.ndarray, decidable: bool) -> list[Measurement]:
    """Rows of drives, scores of shape (drives, frames)."""
    rows = []
    for (drive, frame), score in np.ndenumerate(scores):
        names = {f"{method} {frame}": score for method in DRIVE_METHODS}
        if state == GHOST:
            names[f"decidable {frame}"] = float(decidable and frame % WINDOW == 3)
        rows += [
            Measurement(drive_setting(part, state), f"{drive:06d}", name, value)
            for name, value in names.items()
        ]
    return rows


@pytest.fixture(scope="module")
def summary() -> DrivesSummary:
    """Attack-free scores of mean -1, attacked ones of mean 1, deviation 1, independent."""
    rng, shape = np.random.default_rng(0), (_DRIVES, WINDOW * _WINDOWS)
    rows = _rows(FITTED, CLEAN, rng.normal(-1, 1, shape), False)
    rows += _rows(JUDGED, CLEAN, rng.normal(-1, 1, shape), False)
    rows += _rows(JUDGED, GHOST, rng.normal(1, 1, shape), True)
    found = drives_summary(Kept(rows))  # type: ignore[arg-type]
    assert found is not None
    json.dumps(as_json(found), allow_nan=False)
    return found


def test_simulated_windows_alarm_as_often_as_was_designated(summary: DrivesSummary) -> None:
    assert summary.judged == summary.attacked == summary.fitted == _DRIVES * _WINDOWS
    for row in summary.rates:
        if row.rate is not None:
            assert row.false_alarms.rate == pytest.approx(row.rate, abs=0.03)
            assert row.drives >= row.false_alarms.rate
            # Small evidence that lasts adds up, which no single instant shows.
            assert row.of_decidable.rate is not None
            assert row.by_highest.rate is not None
            assert row.of_decidable.rate > row.by_highest.rate


def test_false_alarms_are_stated_at_a_designated_detection(summary: DrivesSummary) -> None:
    at = [row for row in summary.rates if row.rate is None]
    assert [row.method for row in at] == list(DRIVE_METHODS)
    for row in at:
        assert row.of_decidable.rate == pytest.approx(0.95, abs=0.01)
        assert row.false_alarms.count == 0
        assert row.drives == pytest.approx(rate_bound(_DRIVES, 0))
        assert row.by_highest.rate is None


def test_the_section_is_whole(summary: DrivesSummary) -> None:
    section = drives_section(summary)
    [table] = section.tables
    assert len(table.rows) == len(summary.rates) == 8
    assert {len(line) for line in table.rows} == {len(table.columns)}


def test_a_window_that_ended_early_is_left_out() -> None:
    scores = np.zeros((2, WINDOW * 2))
    rows = [
        row
        for row in _rows(JUDGED, GHOST, scores, False)
        if not (row.scenario == "000001" and int(row.name.rpartition(" ")[2]) > 14)
    ]
    windows = drive_windows(Kept(rows), JUDGED, GHOST)  # type: ignore[arg-type]
    assert windows.drives == ["000000", "000000", "000001"]
    assert not any(windows.decidable)


def test_without_judged_drives_nothing_is_shown() -> None:
    rows = _rows(FITTED, CLEAN, np.zeros((2, WINDOW)), False)
    assert drives_summary(Kept(rows)) is None  # type: ignore[arg-type]


def test_each_drive_has_a_cell() -> None:
    cells = drive_cells(Configuration("procedural", 3, options={"windows": 2}))
    assert len(set(cells)) == len(cells) == 6
    assert {cell.arguments["part"] for cell in cells} == {FITTED, JUDGED}
    assert set(drive_inputs(Configuration("procedural"))) == {"constants", "model"}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (Configuration("mixed"), "procedural"),
        (Configuration("procedural", seed=1000), "0 to 999"),
        (Configuration("procedural", options={"windows": 0}), "windows"),
        (Configuration("procedural", options={"windows": True}), "windows"),
    ],
)
def test_what_cannot_be_is_refused(wrong: Configuration, message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        drive_cells(wrong)
