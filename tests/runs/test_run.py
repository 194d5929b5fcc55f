"""A run: what is done once, what is done again, what is refused."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.runs.experiment import Cell, Configuration, Experiment
from avsec_gym.runs.run import RunSummary, run_experiments
from avsec_gym.runs.run_folder import RunFolder

Rows = Callable[[Path], dict[str, list[tuple[Any, ...]]]]
SMALL = Configuration(limit=3, seed=7)


def go(
    root: Path, *experiments: Experiment, asked: Configuration = SMALL, **how: Any
) -> RunSummary:
    return run_experiments(experiments, asked, root, **{"workers": 0, "threads": 1} | how)


def test_what_two_experiments_need_is_done_once(
    tiny: ModuleType, diary: Path, tmp_path: Path, rows: Rows
) -> None:
    told = []
    report = go(
        tmp_path / "run",
        tiny.PRECISION,
        tiny.SAFETY,
        on_progress=lambda done, total: told.append((done, total)),
    )
    assert (report.cells, report.done, report.kept, report.failures) == (9, 9, 0, ())
    assert len(diary.read_text().splitlines()) == 9
    assert told == [(n, 9) for n in range(1, 10)]
    run = RunFolder.open(tmp_path / "run")
    assert len(run.cells("precision")) == len(run.cells("safety")) == 6
    # Joining later gives the same rows.
    go(tmp_path / "one", tiny.SAFETY)
    assert go(tmp_path / "one", tiny.PRECISION).kept == 3
    assert rows(tmp_path / "one") == rows(tmp_path / "run")
    assert RunFolder.open(tmp_path / "one").experiments == ("safety", "precision")


def test_the_seed_decides(tiny: ModuleType, tmp_path: Path, rows: Rows) -> None:
    go(tmp_path / "a", tiny.PRECISION)
    go(tmp_path / "b", tiny.PRECISION)
    go(tmp_path / "c", tiny.PRECISION, asked=Configuration(limit=3, seed=8))
    assert rows(tmp_path / "a") == rows(tmp_path / "b") != rows(tmp_path / "c")


def test_failed_cells_are_noted_and_tried_again_when_asked(
    tiny: ModuleType, diary: Path, tmp_path: Path
) -> None:
    root = tmp_path / "run"
    experiment = tiny.trouble("fine", "data", "bug", "exit", "no result", "fine")
    report = go(root, experiment)
    assert (report.done, len(report.failures)) == (2, 4)
    errors = [cell.error for cell in RunFolder.open(root).failures()]
    assert errors[0] == "000001.png: the frame is dark."
    assert errors[1:3] == ["ZeroDivisionError: a slip", "SystemExit: enough"]
    assert "CellResult" in errors[3]
    assert 'raise ZeroDivisionError("a slip")' in (root / "run.log").read_text()
    again = go(root, experiment)
    assert (again.kept, again.done, again.failed_before) == (2, 0, 4)
    assert len(diary.read_text().splitlines()) == 6
    diary.with_name("diary.repaired").touch()
    report = go(root, experiment, retry=True)
    assert (report.kept, report.done, report.failures, report.failed_before) == (2, 4, (), 0)
    assert not RunFolder.open(root).failures()


def test_rows_that_another_cell_has_given_are_a_failure(tiny: ModuleType, tmp_path: Path) -> None:
    report = go(tmp_path / "run", tiny.trouble("twins", "fine", "twins"))
    assert [cell.arguments["number"] for cell, _ in report.failures] == [2]
    assert "UNIQUE" in report.failures[0][1]
    assert len(RunFolder.open(tmp_path / "run").measurements()) == 2


def test_another_configuration_is_refused_by_name(
    tiny: ModuleType, diary: Path, tmp_path: Path, rows: Rows
) -> None:
    root, weights = tmp_path / "run", tmp_path / "weights"
    weights.write_text("1")
    options = {"weights": str(weights)}
    usual = {"scenarios": "mixed", "limit": 3, "seed": 7, "options": options}
    go(root, tiny.PRECISION, asked=Configuration(**usual))
    before, begun = rows(root), len(diary.read_text().splitlines())
    for change, told in (
        ({"scenarios": "street"}, 'scenarios "mixed", asked is "street"'),
        ({"limit": 4}, "limit 3, asked is 4"),
        ({"seed": 8}, "seed 7, asked is 8"),
        ({"options": options | {"pause": 0.5}}, "pause 0.0, asked is 0.5"),
    ):
        with pytest.raises(DataError, match=told):
            go(root, tiny.PRECISION, asked=Configuration(**usual | change))  # type: ignore[arg-type]
    with pytest.raises(DataError, match="threads 1, asked is 2"):
        go(root, tiny.PRECISION, asked=Configuration(**usual), threads=2)
    weights.write_text("2")
    with pytest.raises(DataError, match="weights"):
        go(root, tiny.PRECISION, asked=Configuration(**usual))
    assert rows(root) == before
    weights.write_text("1")
    assert go(root, tiny.PRECISION, asked=Configuration(**usual), threads=None).kept == 6
    assert len(diary.read_text().splitlines()) == begun


def test_experiments_that_ask_for_other_cells_than_before_are_refused(
    tiny: ModuleType, tmp_path: Path, rows: Rows
) -> None:
    root = tmp_path / "run"
    go(root, tiny.trouble("fine", "odd"))
    before = rows(root)
    assert go(root, tiny.trouble("fine", "odd", "new")).kept == 2
    with pytest.raises(DataError, match=r'no longer asked for.*"odd"'):
        go(root, tiny.trouble("fine"))
    assert len(rows(root)["cells"]) == len(before["cells"]) + 1


def test_a_work_that_cannot_be_made_stops_the_run(tiny: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no weights"):
        go(tmp_path / "run", tiny.only("no_work", 3))
    with pytest.raises(ConfigurationError, match="nowhere"):
        go(tmp_path / "run2", tiny.only("nowhere"))
    assert RunFolder.open(tmp_path / "run").missing() == 3


def test_a_run_without_results_begins_anew(tiny: ModuleType, tmp_path: Path) -> None:
    root = tmp_path / "run"
    with pytest.raises(DataError, match="no weights"):
        go(root, tiny.only("no_work", 3))
    assert go(root, tiny.PRECISION, asked=Configuration(limit=2)).done == 4
    run = RunFolder.open(root)
    assert run.experiments == ("precision",)
    assert run.missing() == 0


def test_folders_of_something_else_are_left_alone(tiny: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full/thesis.tex").touch()
    with pytest.raises(DataError, match=r"thesis\.tex"):
        go(tmp_path / "full", tiny.PRECISION)
    (tmp_path / "data").mkdir()
    (tmp_path / "data/manifest.json").write_text('{"format": 1}')
    with pytest.raises(DataError, match="no manifest of a run"):
        go(tmp_path / "data", tiny.PRECISION)
    with pytest.raises(DataError, match="a file"):
        go(tmp_path / "full/thesis.tex", tiny.PRECISION)
    assert [path.name for path in (tmp_path / "full").iterdir()] == ["thesis.tex"]
    go(tmp_path / "run", tiny.PRECISION)
    (tmp_path / "run/results.sqlite").write_bytes(b"not a database, whatever its name says" * 99)
    with pytest.raises(DataError, match="not a database"):
        go(tmp_path / "run", tiny.PRECISION)


def test_arguments_that_cannot_work(tiny: ModuleType, tmp_path: Path) -> None:
    nothing = Experiment("nothing", "", "", lambda configuration: [])
    for experiments, how, told in (
        ([tiny.PRECISION], {"workers": -1}, "--workers"),
        ([tiny.PRECISION], {"threads": 0}, "--threads"),
        ([tiny.PRECISION, tiny.PRECISION], {}, "different names"),
        ([], {}, "different names"),
        ([nothing], {}, "nothing to do"),
        ([tiny.SAFETY], {"asked": Configuration(options={"pause": 1})}, "Known: planner"),
        ([tiny.SAFETY], {"asked": Configuration(options={"planner": 1})}, "like \"astar\", got 1"),
    ):  # fmt: skip
        with pytest.raises(ConfigurationError, match=told):
            go(tmp_path / told, *experiments, **how)
    # Nothing is left behind.
    assert not list(tmp_path.iterdir())


def test_the_manifest_tells_what_was_run(
    tiny: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    root, weights = tmp_path / "run", tmp_path / "weights"
    weights.write_bytes(b"abc")
    asked = Configuration(limit=1, options={"weights": str(weights)})
    go(root, tiny.PRECISION, asked=asked)
    go(root, tiny.trouble("fine"), asked=Configuration(limit=1))
    go(root, tiny.PRECISION, asked=asked)  # Nothing is left to do: no sitting.
    manifest = json.loads((root / "manifest.json").read_text())
    assert manifest["configuration"] == {
        "scenarios": "mixed", "limit": 1, "seed": 0,
        "options": {"pause": 0.0, "weights": str(weights)},
    }  # fmt: skip
    assert manifest["experiments"]["precision"]["thesis"] == "Figure 5.1"
    # SHA-256 of "abc", FIPS 180-2, appendix B.1.
    assert manifest["inputs"]["weights"]["sha256"].startswith("ba7816bf8f01cfea414140de5dae2223")
    # A record that others read names no folder of this machine that it need not.
    assert manifest["inputs"]["weights"]["path"] == "weights"
    first, second = manifest["sittings"]
    assert first["versions"].keys() >= {"avsec-gym", "numpy", "torch"}
    assert (first["done"], second["done"]) == (2, 1)
    assert first["started"] >= manifest["started"]
    assert sorted(path.name for path in root.iterdir()) == [
        "figures", "manifest.json", "results.sqlite", "run.log",
    ]  # fmt: skip


def test_another_version_may_go_on_and_says_so(
    tiny: ModuleType, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    root = tmp_path / "run"
    go(root, tiny.PRECISION)
    assert "changed" not in caplog.text
    manifest = json.loads((root / "manifest.json").read_text())
    manifest["sittings"][-1]["sources"] = "another"
    (root / "manifest.json").write_text(json.dumps(manifest))
    go(root, tiny.PRECISION)
    assert "changed" not in caplog.text, "there was nothing to do"
    go(root, tiny.SAFETY)
    assert "the sources changed" in caplog.text
    assert "the sources changed" in (root / "run.log").read_text()


HOLD = """
import sys, time
from pathlib import Path
from avsec_gym.storage.folder_lock import folder_lock
with folder_lock(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


def test_one_process_at_a_time(tiny: ModuleType, tmp_path: Path) -> None:
    root = tmp_path / "run"
    go(root, tiny.PRECISION)
    holder = subprocess.Popen([sys.executable, "-c", HOLD, str(root)], stdout=subprocess.PIPE)
    try:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"held\n"
        with pytest.raises(DataError, match="Another process is writing here"):
            go(root, tiny.PRECISION)
        # Readers may look on.
        assert len(RunFolder.open(root).cells()) == 6
    finally:
        holder.send_signal(signal.SIGKILL)
        holder.wait()
        holder.stdout.close()
    assert go(root, tiny.PRECISION).kept == 6


def test_cells_of_a_group_come_one_after_another(
    tiny: ModuleType, diary: Path, tmp_path: Path
) -> None:
    go(tmp_path / "run", tiny.PRECISION, tiny.SAFETY)
    scenarios = [line.split()[0] for line in diary.read_text().splitlines()]
    assert scenarios == sorted(scenarios)
    assert Cell.of("a:b", "x", n=1) == Cell.of("a:b", "y", n=1) != Cell.of("a:b", n=2)
