"""A run of old names, made by hand as earlier releases made it, is read and goes on."""

from __future__ import annotations

import hashlib
import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.report.run_report import run_report
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    Experiment,
    Measurement,
)
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.schema import DIGESTS, SCHEMA
from avsec_gym.runs.soundness import digests
from avsec_gym.runs.stored_boxes import boxes_to_text

WORK = f"{__name__}:work"
OLD_ATTACKS = ("unattacked", "pgd-0.4", "texture-pgd-1")
NEW_ATTACKS = ("unattacked", "thesis_pgd-0.4", "texture-thesis_pgd-1")


def work(configuration: Configuration) -> object:
    def measured(attack: str) -> CellResult:
        row = Measurement(f"mine {attack}", "000001", "loss", -1.0, 4.0)
        return CellResult(measurements=[row])

    return measured


def cells_of(attacks: tuple[str, ...]) -> list[Cell]:
    return [Cell.of(WORK, attack=attack) for attack in attacks]


def experiment(name: str, attacks: tuple[str, ...]) -> Experiment:
    return Experiment(name, "Is it so?", "Table 5.1", lambda asked: cells_of(attacks))


PERTURBATION = experiment("perturbation", (*NEW_ATTACKS, "thesis_pgd-1"))
OTHER = experiment("other", ("pgd-0.4 of others",))
"""An experiment of others may use the name as it likes."""


@pytest.fixture
def old_run(tmp_path: Path) -> Path:
    """The last of four cells of `perturbation` is not done."""
    manifest = {
        "kind": "avsec run",
        "format": 1,
        "started": "2026-11-01T12:00:00+00:00",
        "configuration": {"scenarios": "mixed", "limit": None, "seed": 0, "options": {}},
        "threads": 1,
        "experiments": {
            name: {"question": "Is it so?", "thesis": "", "section": ""}
            for name in ("perturbation", "other")
        },
        "inputs": {},
        "sittings": [
            {
                "started": "2026-11-01T12:00:00+00:00", "ended": None, "versions": {},
                "sources": "", "python": "", "platform": "", "processors": None,
            }
        ],
    }  # fmt: skip
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    with closing(sqlite3.connect(tmp_path / "results.sqlite")) as database, database:
        database.executescript(SCHEMA + DIGESTS + "PRAGMA user_version = 2;")
        finished = [("perturbation", attack) for attack in OLD_ATTACKS]
        for number, (name, attack) in enumerate([*finished, ("other", "pgd-0.4 of others")]):
            key = f'{{"attack":"{attack}"}}'
            cell = hashlib.sha256(f"{WORK} {key}".encode()).hexdigest()[:16]
            add = database.execute
            add("INSERT INTO needs VALUES (?, ?)", [name, cell])
            add("INSERT INTO cells VALUES (?, ?, ?, 'done', NULL, 1, '')", [cell, WORK, key])
            setting = f"mine {attack}"
            rounded = f"mine {attack} 8-bit"
            for under in (setting, rounded):
                boxes = boxes_to_text(Boxes3D.empty())
                row = [cell, under, 4.0, "000001", boxes]
                add("INSERT INTO detections VALUES (?, ?, ?, ?, ?)", row)
            row = [cell, setting, 4.0, "000001", "loss", float(number)]
            add("INSERT INTO measurements VALUES (?, ?, ?, ?, ?, ?)", row)
            row = [cell, setting, 4.0, "000001", "left", "astar", "safe", 3]
            add(
                "INSERT INTO drives (cell, setting, strength, scenario, intention, planner,"
                " outcome, expanded) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                row,
            )
        missing = hashlib.sha256(f'{WORK} {{"attack":"pgd-1"}}'.encode()).hexdigest()[:16]
        database.execute("INSERT INTO needs VALUES ('perturbation', ?)", [missing])
        database.executemany("INSERT INTO digests VALUES (?, ?)", digests(database).items())
    return tmp_path


def check_rows(run: RunFolder) -> None:
    losses = {row.setting: row.value for row in run.measurements(name="loss")}
    assert losses.items() >= {
        "mine unattacked": 0.0, "mine thesis_pgd-0.4": 1.0,
        "mine texture-thesis_pgd-1": 2.0, "mine pgd-0.4 of others": 3.0,
    }.items()  # fmt: skip
    assert list(run.detections("mine thesis_pgd-0.4 8-bit", 4.0)) == ["000001"]
    assert [row.record.safe for row in run.episodes(setting="mine thesis_pgd-0.4")] == [True]
    attacks = {cell.arguments["attack"] for cell in run.cells()}
    assert attacks >= {*NEW_ATTACKS, "pgd-0.4 of others"}
    assert ("mine texture-thesis_pgd-1", 4.0) in run.settings()


def test_it_is_read_in_the_new_names_and_left_as_it_is(old_run: Path) -> None:
    before = (old_run / "results.sqlite").read_bytes()
    run = RunFolder.open(old_run)
    check_rows(run)
    assert run.missing() == 1
    rates = {row["setting"] for row in run_report(run).data["other"]}
    assert "mine thesis_pgd-0.4" in rates
    assert (old_run / "results.sqlite").read_bytes() == before


def test_it_goes_on_where_it_was(old_run: Path) -> None:
    done = run_experiments([PERTURBATION], Configuration(), old_run, workers=0)
    assert (done.cells, done.kept, done.done) == (4, 3, 1)
    run = RunFolder.open(old_run)
    check_rows(run)
    assert run.measurements(setting="mine thesis_pgd-1")[0].value == -1.0
    assert (run.missing(), len(run.cells())) == (0, 5)
    # Once more, and by the other experiment: nothing is left to do, and nothing was lost.
    for each in (PERTURBATION, OTHER):
        assert run_experiments([each], Configuration(), old_run, workers=0).done == 0
    check_rows(RunFolder.open(old_run))


def test_a_row_that_was_changed_is_found_before_it_is_renamed(old_run: Path) -> None:
    with closing(sqlite3.connect(old_run / "results.sqlite")) as database, database:
        database.execute("UPDATE measurements SET value = 7 WHERE value = 1")
    with pytest.raises(DataError, match="not what was written"):
        run_experiments([PERTURBATION], Configuration(), old_run, workers=0)


def test_an_earlier_name_is_an_error_that_names_both_forms(old_run: Path) -> None:
    run = RunFolder.open(old_run)
    for asked in (run.records, run.measurements):
        with pytest.raises(ConfigurationError, match=r"'mine thesis_pgd-0.4'.*projected_pgd"):
            asked(setting="mine pgd-0.4")
    assert run.measurements(setting="mine pgd-0.4 of others", strength=1) == []


def test_experiments_are_renamed_in_the_tables_too(old_run: Path) -> None:
    with closing(sqlite3.connect(old_run / "results.sqlite")) as database, database:
        database.execute("UPDATE needs SET experiment = 'knowing' WHERE experiment = 'other'")
    (cell,) = RunFolder.open(old_run).cells("adaptive_attacks")
    assert cell.arguments == {"attack": "pgd-0.4 of others"}


def test_parts_in_the_options_of_a_run_are_renamed(old_run: Path) -> None:
    path = old_run / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["experiments"] = {"pipeline": manifest["experiments"]["other"]}
    manifest["configuration"]["options"] = {"attack": {"name": "pgd", "alpha": 0.4}, "planner": "x"}
    path.write_text(json.dumps(manifest))
    options = RunFolder.open(old_run).configuration.options
    assert options == {"attack": {"name": "thesis_pgd", "alpha": 0.4}, "planner": "x"}
