"""What a run stores is what is read back, and what the documentation says."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
import os
import re
import shutil
import sqlite3
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.runs.catalogue import EXPERIMENTS, experiment
from avsec_gym.runs.cell_worker import Done, Failed
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    EpisodeRow,
    Measurement,
    with_defaults,
)
from avsec_gym.runs.fingerprints import fingerprint
from avsec_gym.runs.manifest import MANIFEST
from avsec_gym.runs.rows import rows_of
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.schema import ADDED, VERSION, schema
from avsec_gym.runs.store import ResultStore
from avsec_gym.runs.stored_boxes import boxes_from_text, boxes_to_text

NAN = math.nan
RECORDS = [
    SafetyRecord(
        "000001", "left", "safe", 1.5, 12, 15.25, 2.0, sm1_cost=3.5, swept_collision=False
    ),
    SafetyRecord("000001", "right", "unplanned", NAN, 99, NAN, NAN, "exhausted", 2.5),
    SafetyRecord("000002", "left", "collision", 1.0, 7, 9.5, 1.5, None, NAN, 0.7, 3, 4.5, True),
]


@pytest.fixture
def run(tiny: ModuleType, tmp_path: Path) -> RunFolder:
    """One cell by hand beside those of a tiny experiment."""
    root = tmp_path / "run"
    asked = Configuration(limit=2)
    run_experiments([tiny.PRECISION], asked, root, workers=0, threads=1)
    boxes = Boxes3D(
        np.float32([[1.1, 1.65, 20.3]]), [[1.5, 1.6, 4]], [0.1], [0.9], ["Car"], moving=[True]
    )
    result = CellResult(
        [EpisodeRow("dsgn", record, 4) for record in reversed(RECORDS)],
        [DetectionRow("dsgn", "000001", boxes, 4), DetectionRow("dsgn", "000000", boxes[:0], 4)],
        [Measurement("dsgn", "000001", "loss", np.float32(0.5)), Measurement("", "", "no", NAN)],
        {"attack": 2.0},
    )
    store = ResultStore(root / "results.sqlite")
    store.add(Cell.of("here:Work", n=1), Done(rows_of(result), 3.0))
    store.close()
    return RunFolder.open(root)


def same(one: Any, two: Any) -> bool:
    return one == two or (one != one and two != two)


def test_records_come_back_as_they_were(run: RunFolder) -> None:
    records = run.records(setting="dsgn", strength=4, planner="astar")
    assert len(records) == 3
    for there, back in zip(RECORDS, records, strict=True):
        facts, found = dataclasses.asdict(there), dataclasses.asdict(back)
        assert all(same(facts[name], found[name]) for name in facts), (facts, found)
    assert SafetyRates.of(records).safe_driving_rate == 1 / 3
    rows = run.episodes(setting="dsgn")
    assert repr([row.record for row in rows]) == repr(RECORDS)
    assert {(row.setting, row.strength, row.planner) for row in rows} == {("dsgn", 4.0, "astar")}
    there_are = {
        name: len(run.episodes(setting="dsgn", **{name: 1}))
        for name in ("planned", "collision", "safe")
    }
    assert there_are == {"planned": 2, "collision": 1, "safe": 1}
    assert len(run.episodes()) == 3 + 2 * 2 * 2
    assert not run.episodes(setting="dsgn", strength=3)


def test_folders_of_earlier_releases_open_and_go_on(run: RunFolder) -> None:
    path = run.path / "results.sqlite"
    with contextlib.closing(sqlite3.connect(path)) as database:
        for table, name in ADDED:
            database.execute(f"ALTER TABLE {table} DROP COLUMN {name}")
        database.execute("DROP TABLE digests")
        database.execute("DROP TABLE needs_digest")
        database.execute("PRAGMA user_version = 1")
    records = run.records(setting="dsgn", strength=4, planner="astar")
    assert [record.swept_collision for record in records] == [None] * 3
    assert [record.outcome for record in records] == [record.outcome for record in RECORDS]
    assert SafetyRates.of(records).swept_collisions is None
    later = CellResult([EpisodeRow("later", record, 4) for record in RECORDS])
    store = ResultStore(path)
    assert isinstance(store.add(Cell.of("here:Work", n=2), Done(rows_of(later), 3.0)), Done)
    store.close()
    records = run.records(setting="later", strength=4, planner="astar")
    assert [record.swept_collision for record in records] == [False, None, True]
    assert len(run.records(setting="dsgn", strength=4, planner="astar")) == 3


def test_everything_else_comes_back(run: RunFolder) -> None:
    assert run.settings() == [("dsgn", 4.0), ("none", 2.0), ("weak", 2.0)]
    found = run.detections("dsgn", 4)
    assert list(found) == ["000000", "000001"]
    assert len(found["000000"]) == 0
    assert found["000001"].location.astype(np.float32)[0, 0] == np.float32(1.1)
    assert found["000001"].moving is not None
    assert found["000001"].moving.tolist() == [True]
    assert run.measurements(setting="dsgn") == [Measurement("dsgn", "000001", "loss", 0.5)]
    (none,) = run.measurements(name="no")
    assert np.isnan(none.value)
    assert run.timings()["attack"] == {"cells": 1, "seconds": 2.0}
    assert run.cells()[0].arguments == {"n": 1}
    assert [row.arguments["scenario"] for row in run.cells("precision")] == [
        "000000", "000001", "000000", "000001",
    ]  # fmt: skip
    assert run.configuration.limit == 2


@pytest.mark.parametrize("count", [0, 1, 7])
def test_stored_boxes_keep_every_digit_of_float32(count: int) -> None:
    generator = np.random.default_rng(count)
    boxes = Boxes3D(
        generator.normal(0, 50, (count, 3)).astype(np.float32),
        generator.uniform(1, 5, (count, 3)).astype(np.float32),
        generator.normal(size=count).astype(np.float32),
        generator.uniform(size=count).astype(np.float32) ** 9,
        ["Car"] * count,
        box2d=generator.uniform(0, 1242, (count, 4)).astype(np.float32),
    )
    back = boxes_from_text(boxes_to_text(boxes))
    for column in dataclasses.fields(Boxes3D):
        value, found = getattr(boxes, column.name), getattr(back, column.name)
        if value is None or column.name == "category":
            assert (value is None) == (found is None)
            continue
        assert value.shape == found.shape
        assert (value.astype(np.float32) == found.astype(np.float32)).all()


def test_a_cell_is_stored_with_all_its_rows_or_none(run: RunFolder) -> None:
    twice = CellResult(
        measurements=[Measurement("x", "1", "a", 1.0), Measurement("x", "1", "a", 2.0)]
    )
    odd = CellResult(measurements=[Measurement("x", "1", object(), 1.0)])  # type: ignore[arg-type]
    store = ResultStore(run.path / "results.sqlite")
    for number, result in enumerate([twice, odd]):
        outcome = store.add(Cell.of("here:Work", twice=number), Done(rows_of(result), 1.0))
        assert isinstance(outcome, Failed)
        assert "cannot be stored" in outcome.error
    store.close()
    assert not run.measurements(setting="x")
    assert len(run.failures()) == 2


def test_the_documented_schema_is_the_real_one(run: RunFolder) -> None:
    page = (Path(__file__).parents[2] / "docs/runs.md").read_text()
    documented = re.search(r"```sql\n(.*?)\n```", page, re.DOTALL)
    assert documented is not None
    database = sqlite3.connect(run.path / "results.sqlite")
    real = database.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL").fetchall()
    columns = database.execute("SELECT * FROM drives").description
    assert database.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    database.close()
    assert documented.group(1) + "\n" == "".join(f"{sql};\n" for (sql,) in real)
    assert documented.group(1) in schema(VERSION).replace(";\n\n", ";\n")
    # A new field of a record needs a column.
    fields = {column.name for column in dataclasses.fields(SafetyRecord)}
    assert fields <= {name for name, *_ in columns}


def test_a_run_can_be_read_where_nothing_can_be_written(run: RunFolder) -> None:
    for path in [*run.path.iterdir(), run.path]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    try:
        assert len(RunFolder.open(run.path).episodes(setting="dsgn")) == 3
    finally:
        run.path.chmod(0o755)


def test_what_is_no_run_is_told(run: RunFolder, tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no run here"):
        RunFolder.open(tmp_path)
    with pytest.raises(DataError, match="no such column"):
        run.episodes(detector="dsgn")
    database = sqlite3.connect(run.path / "results.sqlite")
    database.execute("PRAGMA user_version = 9")
    database.close()
    with pytest.raises(DataError, match="schema 9"):
        RunFolder.open(run.path)
    (run.path / "results.sqlite").write_bytes(os.urandom(5000))
    with pytest.raises(DataError, match="not a database"):
        RunFolder.open(run.path)


def test_a_fingerprint_sees_texts_whole_and_pictures_by_their_sizes(tmp_path: Path) -> None:
    root = tmp_path / "data"
    for name, content in {"label_2/1.txt": "Car", "image_2/1.png": "png", ".x": "hidden"}.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(content)
    first = fingerprint(root)
    (root / ".x").write_text("more")
    assert fingerprint(root) == first
    (root / "label_2/1.txt").write_text("Van")
    second = fingerprint(root)
    (root / "image_2/1.png").write_text("longer")
    assert len({first, second, fingerprint(root)}) == 3
    (root / "manifest.json").write_text("{}")
    assert fingerprint(root) == fingerprint(root / "manifest.json")
    with pytest.raises(DataError, match="not there"):
        fingerprint(tmp_path / "nothing")


def test_options_that_no_run_takes_are_no_runs(run: RunFolder, tmp_path: Path) -> None:
    """`avsec report` computes with them: null and -1 were raw errors of types."""
    manifest = json.loads((run.path / MANIFEST).read_text())
    asked = next(iter(manifest["experiments"].values()))
    folder = tmp_path / "other"
    shutil.copytree(run.path, folder)

    def opened(name: str, options: dict[str, Any]) -> RunFolder:
        manifest["experiments"] = {name: asked}
        manifest["configuration"]["options"] = options
        (folder / MANIFEST).write_text(json.dumps(manifest))
        return RunFolder.open(folder)

    refused = 0
    for number, name in enumerate(EXPERIMENTS):
        known = experiment(name)
        # Options of other releases are left alone.
        assert opened(name, {**known.options, "of_another_release": None}).experiments == (name,)
        typed = [option for option, default in known.options.items() if default is not None]
        for option in typed[number % max(1, len(typed)) :][:1]:
            bad = -1 if number % 2 and isinstance(known.options[option], list | str) else None
            with pytest.raises(ConfigurationError) as error:
                with_defaults(Configuration(options={option: bad}), [known])
            with pytest.raises(DataError, match=re.escape(str(error.value))) as caught:
                opened(name, {option: bad})
            assert caught.value.path == str(folder / MANIFEST)
            refused += 1
    assert refused > 10
