"""Rates over windows, from runs in which the scores are simulated."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter4.drives.drive_cells import drive_cells, drive_inputs
from avsec_gym.experiments.chapter4.drives.measured_window import (
    MeasuredWindow,
    measured_windows,
    rows_of,
)
from avsec_gym.experiments.chapter4.drives.section import drives_section
from avsec_gym.experiments.chapter4.drives.settings import STATES, WINDOW
from avsec_gym.experiments.chapter4.drives.window_rates import (
    ALL_ALARM,
    HALF,
    ONCE,
    SINGLE,
    SUMS,
    DrivesSummary,
    WindowRates,
    drives_summary,
)
from avsec_gym.experiments.chapter4.settings import ATTACKS, CLEAN, FITTED, JUDGED
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.metrics.tolerance import rate_bound
from avsec_gym.runs.experiment import Configuration, Measurement
from tests.experiments.chapter4.known_run import Kept

_DRIVES = 200


def _clean(drive: int, rng: np.random.Generator) -> MeasuredWindow:
    """Three things that are there, one of which flickers for one instant in half of the windows."""
    scores = rng.normal(-4, 0.5, (3, WINDOW))
    scores[0, 4] = 9.0 if drive % 2 else -4.0
    nowhere = np.zeros(scores.shape, bool)
    return MeasuredWindow(f"{drive:06d}", WINDOW, False, 0, scores, nowhere)


def _attacked(drive: int, rng: np.random.Generator) -> MeasuredWindow:
    """A track of weak evidence that lasts, beside those of an attack-free window."""
    clean = _clean(drive, rng)
    scores = np.concatenate([clean.scores, rng.normal(3.0, 0.5, (1, WINDOW))])
    about = np.zeros(scores.shape, bool)
    about[-1] = True
    return replace(clean, covered=True, decidable=WINDOW, scores=scores, about=about)


def _rows(seed: int) -> list[Measurement]:
    rng, rows = np.random.default_rng(seed), []
    for part in (FITTED, JUDGED):
        for state in STATES:
            for drive in range(_DRIVES):
                window = (_clean if state == CLEAN else _attacked)(drive, rng)
                rows += rows_of(window, part, state, 0)
    return rows


def _summary(rows: list[Measurement]) -> DrivesSummary:
    found = drives_summary(Kept(rows))  # type: ignore[arg-type]
    assert found is not None
    json.dumps(as_json(found), allow_nan=False)
    return found


@pytest.fixture(scope="module")
def summary() -> DrivesSummary:
    return _summary(_rows(0))


def _row(summary: DrivesSummary, of: str, rate: float | None) -> WindowRates:
    """The row of a rate; without one, that of attacks that are decidable once."""
    [row] = [
        each
        for each in summary.rates
        if (each.of, each.rate) == (of, rate) and each.instants in (None, ONCE)
    ]
    return row


def test_attacks_that_are_decidable_once_lower_their_limit_alone() -> None:
    """A tenth of the attacks show no evidence but at one instant: no sum tells of them."""
    rng, rows = np.random.default_rng(7), _rows(7)
    for drive in range(_DRIVES, _DRIVES + _DRIVES // 10):
        rows += rows_of(replace(_clean(drive, rng), decidable=1), FITTED, "removal", 0)
    found = {
        row.instants: row for row in _summary(rows).rates if (row.of, row.rate) == (SUMS, None)
    }
    assert found[ONCE].limit == ALL_ALARM
    assert found[HALF].limit > 0
    assert found[HALF].false_alarms.count == 0


def test_what_lasts_stands_out_of_what_flickers(summary: DrivesSummary) -> None:
    """No single score of an attack is as high as a flicker's, but their sum is."""
    sums, single = _row(summary, SUMS, None), _row(summary, SINGLE, None)
    assert sums.false_alarms.count == 0
    assert single.false_alarms.rate == pytest.approx(0.5)
    for kind in ATTACKS:
        assert sums.attacks[kind].of_decidable.rate == pytest.approx(0.95, abs=0.04)
    assert sums.windows_at_most < 0.03
    assert sums.drives_at_most == pytest.approx(rate_bound(_DRIVES, 0))


def test_an_alarm_elsewhere_is_no_detection() -> None:
    rows = [row for row in _rows(1) if not row.name.startswith("about")]
    found = _row(_summary(rows), SUMS, 0.1)
    for kind in ATTACKS:
        assert found.attacks[kind].detected.count == 0
        assert found.attacks[kind].decidable.count == _DRIVES


def test_where_attacks_have_no_evidence_all_windows_alarm() -> None:
    """A limit that no share of attacks exceeds is none, and is shown as that."""
    rng, rows = np.random.default_rng(2), _rows(2)
    rows = [row for row in rows if not (row.setting.startswith(FITTED) and "ghost" in row.setting)]
    for drive in range(_DRIVES):
        quiet = replace(_clean(drive, rng), covered=True, decidable=WINDOW)
        rows += rows_of(quiet, FITTED, "ghost", 0)
    row = _row(_summary(rows), SUMS, None)
    assert row.limit == ALL_ALARM
    assert row.false_alarms.rate == 1.0
    assert row.windows_at_most == 1.0


def test_limits_are_of_fitted_drives_alone() -> None:
    rows = _rows(3)
    loud = [
        replace(row, value=50.0)
        if row.setting.startswith(JUDGED) and row.name.startswith("score")
        else row
        for row in rows
    ]
    quiet, changed = _summary(rows), _summary(loud)
    assert [row.limit for row in changed.rates] == [row.limit for row in quiet.rates]
    assert changed.correlation == quiet.correlation
    assert _row(changed, SUMS, None).false_alarms.rate == 1.0


def test_an_attack_that_ends_early_is_left_out() -> None:
    rng = np.random.default_rng(4)
    ended = replace(_attacked(7, rng), drive="000999", lasted=4)
    cut = replace(ended, scores=ended.scores[:, :4], about=ended.about[:, :4])
    found = _summary([*_rows(4), *rows_of(cut, JUDGED, "ghost", 0)])
    assert found.begun == {"ghost": _DRIVES + 1, "removal": _DRIVES}
    assert _row(found, SUMS, None).attacks["ghost"].detected.of == _DRIVES


def test_windows_are_read_back() -> None:
    window = _attacked(5, np.random.default_rng(5))
    window.scores[1, 2:5] = np.nan
    kept = Kept(rows_of(window, JUDGED, "removal", 3))
    [read] = measured_windows(kept, JUDGED, "removal")  # type: ignore[arg-type]
    np.testing.assert_array_equal(read.scores, window.scores)
    np.testing.assert_array_equal(read.about, window.about)
    assert (read.drive, read.lasted, read.covered, read.decidable) == (
        "000005",
        WINDOW,
        True,
        WINDOW,
    )


def test_the_section_is_whole(summary: DrivesSummary) -> None:
    section = drives_section(summary)
    assert [len(table.rows) for table in section.tables] == [15, 30]
    for table in section.tables:
        assert {len(line) for line in table.rows} == {len(table.columns)}
    [of_sums, of_single, of_half] = section.sentences
    assert "goal: 0.1 %, neither met nor missed" in of_sums
    assert "single instant" in of_single
    assert "half of the instants" in of_half


def test_windows_that_overlap_are_named(summary: DrivesSummary) -> None:
    assert "overlap" not in (drives_section(summary).context or "")
    assert "every 0.2 s, which overlap" in (drives_section(summary, 2).context or "")


def test_without_judged_drives_nothing_is_shown() -> None:
    rows = [row for row in _rows(6) if row.setting.startswith(FITTED)]
    assert drives_summary(Kept(rows)) is None  # type: ignore[arg-type]


def test_each_drive_has_a_cell() -> None:
    cells = drive_cells(Configuration("procedural", 5, options={"windows": 2, "attacked": 2}))
    assert len(set(cells)) == len(cells) == 7
    fitted = [cell.arguments for cell in cells if cell.arguments["part"] == FITTED]
    assert [(each["number"], each["windows"], each["attacked"]) for each in fitted] == [
        (0, 1, True),
        (1, 1, True),
    ]
    judged = [cell.arguments for cell in cells if cell.arguments["part"] == JUDGED]
    assert [each["attacked"] for each in judged] == [True, True, False, False, False]
    assert set(drive_inputs(Configuration("procedural"))) == {"constants"}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (Configuration("mixed"), "procedural"),
        (Configuration("procedural", seed=1000), "0 to 999"),
        (Configuration("procedural", options={"windows": 0}), "windows"),
        (Configuration("procedural", options={"windows": True}), "windows"),
        (Configuration("procedural", options={"apart": 0}), "apart"),
        (Configuration("procedural", options={"apart": 11}), "apart"),
        (Configuration("procedural", options={"attacked": 0}), "attacked"),
    ],
)
def test_what_cannot_be_is_refused(wrong: Configuration, message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        drive_cells(wrong)
