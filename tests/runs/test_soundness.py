"""Damaged results are refused when they are opened; what opens holds what was written."""

from __future__ import annotations

import os
import random
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.errors import DataError
from avsec_gym.runs import run_folder
from avsec_gym.runs.cell_worker import Done
from avsec_gym.runs.experiment import Cell, CellResult, Measurement
from avsec_gym.runs.rows import rows_of
from avsec_gym.runs.run import RESULTS
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.schema import VERSION
from avsec_gym.runs.soundness import check_sound
from avsec_gym.runs.store import ResultStore, has_results

MUTATIONS = 250


def result(number: int) -> Done:
    names = ("loss", "share of cars")
    values = [Measurement("none", f"{number:06d}", name, number / 7) for name in names]
    return Done(rows_of(CellResult(measurements=values)), 0.1 * number)


@pytest.fixture
def sound(tmp_path: Path) -> Path:
    path = tmp_path / "sound" / RESULTS
    path.parent.mkdir()
    with closing(ResultStore(path)) as store:
        cells = [Cell.of("here:Work", n=number) for number in range(12)]
        store.plan({"here": cells}, ["here"])
        for number, cell in enumerate(cells):
            store.add(cell, result(number))
    return path


def rows(path: Path) -> list[Any]:
    """Everything that can be read of an opened run; DataError where it cannot be opened."""
    run = RunFolder(path.parent, {})
    with closing(ResultStore(path)) as store:
        statuses = store.statuses()
    tables = [run._rows(f"SELECT * FROM {name}") for name in ("measurements", "drives")]
    found = repr([run.cells(), run.measurements(), run.episodes()])
    return [statuses, tables, found, run.missing(), run.timings()]


def mutated(content: bytearray, randomness: random.Random) -> bytes:
    place, length = randomness.randrange(len(content)), randomness.randrange(1, 200)
    match randomness.randrange(5):
        case 0:
            del content[place:]
        case 1 | 2:
            for _ in range(randomness.choice([1, 1, 4, 16])):
                # Where something is written, rather than in what is free.
                there = [i for i in range(len(content)) if content[i]]
                content[randomness.choice(there)] = randomness.randrange(256)
        case 3:
            content[place : place + length] = bytes(length)
        case _:
            del content[place : place + length]
    return bytes(content)


def test_what_opens_holds_what_was_written(sound: Path, tmp_path: Path) -> None:
    expected, content = rows(sound), sound.read_bytes()
    damaged = tmp_path / "damaged" / RESULTS
    randomness, refused = random.Random(0), 0
    for _ in range(MUTATIONS):
        shutil.rmtree(damaged.parent, ignore_errors=True)
        damaged.parent.mkdir()
        damaged.write_bytes(mutated(bytearray(content), randomness))
        if not damaged.stat().st_size:
            continue
        found = opened(damaged)
        refused += found is None
        assert found is None or found == expected
    assert refused > MUTATIONS / 2


def opened(path: Path) -> list[Any] | None:
    try:
        return rows(path)
    except DataError as error:
        assert error.path == str(path)  # noqa: PT017 - raised or not
        return None


CHANGES = {
    "a value": "UPDATE measurements SET value = 9.5 WHERE scenario = '000003'",
    "a missing row": "DELETE FROM measurements WHERE scenario = '000003'",
    "a row too many": "INSERT INTO measurements SELECT cell, setting, strength, 'new', name, value"
    " FROM measurements LIMIT 1",
    "a time": "UPDATE cells SET seconds = 3.5 WHERE rowid = 4",
    "arguments": "UPDATE cells SET arguments = '{}' WHERE rowid = 4",
    "no digest": "DELETE FROM digests WHERE rowid = 4",
    "a need that is gone": "DELETE FROM needs WHERE rowid = 4",
    "all needs": "DELETE FROM needs",
    "a need that no experiment has": "INSERT INTO needs VALUES ('here', 'invented')",
    "a need of others": "UPDATE needs SET experiment = 'there' WHERE rowid = 4",
    "no digest of the needs": "DELETE FROM needs_digest",
    "two digests of the needs": "INSERT INTO needs_digest SELECT * FROM needs_digest",
    "a trigger": "CREATE TRIGGER t AFTER INSERT ON cells BEGIN DELETE FROM cells; END",
    "a table of others": "CREATE TABLE others (x)",
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES.keys())
def test_a_change_that_sqlite_does_not_mind_is_found(sound: Path, change: str) -> None:
    with closing(sqlite3.connect(sound)) as database, database:
        database.execute(change)
    for opening in (ResultStore, has_results):
        with pytest.raises(DataError, match="damaged"):
            opening(sound)


def test_every_table_is_held_by_a_digest(sound: Path) -> None:
    """A table that is added to the schema some day, too."""
    with closing(sqlite3.connect(sound)) as database:
        tables = [row[0] for row in database.execute("SELECT name FROM sqlite_master").fetchall()]
        filled = [
            name
            for name in tables
            if not name.startswith("sqlite_")
            and database.execute(f"SELECT 1 FROM {name}").fetchone() is not None
        ]
    content = sound.read_bytes()
    assert {"needs", "cells", "measurements", "digests", "needs_digest"} <= set(filled)
    for name in filled:
        sound.write_bytes(content)
        with closing(sqlite3.connect(sound)) as database, database:
            database.execute(f"DELETE FROM {name} WHERE rowid = (SELECT min(rowid) FROM {name})")
        with pytest.raises(DataError, match="damaged"):
            ResultStore(sound)


def old(path: Path, version: int = 1) -> Path:
    """Results as an earlier version of the schema had them."""
    with closing(sqlite3.connect(path)) as database, database:
        database.execute("DROP TABLE needs_digest")
        if version == 1:
            database.execute("DROP TABLE digests")
        database.execute(f"PRAGMA user_version = {version}")
    return path


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize(
    "change",
    ["UPDATE measurements SET value = 0.5 WHERE scenario = '000003'", "DELETE FROM needs"],
)
def test_old_runs_are_read_and_gone_on_with(sound: Path, version: int, change: str) -> None:
    before = RunFolder(sound.parent, {}).measurements()
    old(sound, version)
    assert RunFolder(sound.parent, {}).measurements() == before
    with closing(ResultStore(sound)) as store:
        store.add(Cell.of("here:Work", n=99), result(99))
    assert len(RunFolder(sound.parent, {}).measurements()) == len(before) + 2
    with closing(sqlite3.connect(sound)) as database, database:
        assert database.execute("PRAGMA user_version").fetchone() == (VERSION,)
        database.execute(change)
    with pytest.raises(DataError, match=r"as written|not what was written"):
        ResultStore(sound)


def test_texts_that_are_none_are_found_without_digests(sound: Path) -> None:
    with closing(sqlite3.connect(old(sound))) as database, database:
        database.execute("UPDATE measurements SET setting = CAST(x'ff' AS TEXT)")
    with pytest.raises(DataError, match="decode"):
        ResultStore(sound)


def test_a_database_of_something_else_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / RESULTS
    with closing(sqlite3.connect(path)) as database, database:
        database.execute("CREATE TABLE mine (x)")
    with pytest.raises(DataError, match="something else"):
        ResultStore(path)
    with closing(sqlite3.connect(path)) as database:
        assert database.execute("SELECT count(*) FROM mine").fetchone() == (0,)


@pytest.mark.parametrize("content", [None, b""], ids=["missing", "empty"])
def test_results_of_a_run_that_has_begun_have_to_be_there(
    tmp_path: Path, content: bytes | None
) -> None:
    path = tmp_path / RESULTS
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(DataError, match="are gone"):
        has_results(path, begun=True)
    if content is not None:  # Who only reads is told the same.
        with closing(sqlite3.connect(path)) as database, pytest.raises(DataError, match="are gone"):
            check_sound(database, path)
    assert path.exists() == (content is not None)
    assert not has_results(path)


@pytest.mark.parametrize("begun", [True, False])
def test_a_link_that_leads_nowhere_is_left_as_it_is(tmp_path: Path, begun: bool) -> None:
    """Such as one to a disk that is not mounted."""
    path = tmp_path / RESULTS
    path.symlink_to(tmp_path / "absent" / "kept.sqlite")
    (tmp_path / "near.sqlite").symlink_to(tmp_path / "kept.sqlite")
    for place in (path, tmp_path / "near.sqlite"):
        for opening in (has_results, ResultStore):
            with pytest.raises(DataError, match="are gone"):
                opening(place, begun=begun)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["near.sqlite", RESULTS]
    assert path.is_symlink()


def test_reading_leaves_no_files_beside_the_results(
    sound: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected, refused = rows(sound), 0
    content, randomness = sound.read_bytes(), random.Random(1)
    manifest = {"experiments": [], "configuration": {"options": {}}}
    monkeypatch.setattr(run_folder, "read_manifest", lambda _: manifest)
    for number in range(60):
        sound.write_bytes(content if number == 0 else mutated(bytearray(content), randomness))
        written = sound.read_bytes()
        try:
            RunFolder.open(sound.parent)
            assert rows(sound) == expected
        except DataError:
            refused += 1
        with suppress(DataError):
            ResultStore(sound, begun=True).close()
        assert [path.name for path in sound.parent.iterdir()] == [RESULTS]
        assert sound.read_bytes() == written
    assert 20 < refused < 60


def test_the_log_of_a_run_that_was_killed_is_read_and_left(sound: Path, tmp_path: Path) -> None:
    killed = tmp_path / "killed" / RESULTS
    killed.parent.mkdir()
    with closing(ResultStore(sound)) as store:
        store.add(Cell.of("here:Work", n=12), result(12))
        for path in sound.parent.iterdir():  # What a killed process leaves.
            shutil.copy(path, killed.parent / path.name)
    before = killed.read_bytes()
    log = killed.with_name(f"{RESULTS}-wal").read_bytes()
    assert log
    assert len(RunFolder(killed.parent, {}).cells()) == 13
    assert killed.read_bytes() == before
    assert killed.with_name(f"{RESULTS}-wal").read_bytes() == log


def fill(path: Path) -> None:
    """Add cells until there is no place; beyond SQLite's bound on pages is a full disk's error."""
    with closing(ResultStore(path)) as store:
        store._database.execute("PRAGMA max_page_count = 1")
        for number in range(100, 2000):
            store.add(Cell.of("here:Work", n=number), result(number))


def test_a_full_disk_is_no_reason_to_remove_a_run(sound: Path) -> None:
    with pytest.raises(DataError, match="full") as caught:
        fill(sound)
    assert "Free some space" in caught.value.remedy
    assert "remove" not in str(caught.value)
    assert len(rows(sound)[0]) >= 12


def pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def device(path: Path) -> None:
    path.unlink()
    path.symlink_to("/dev/zero")


@pytest.mark.parametrize("change", [pipe, device])
def test_only_regular_files_are_opened(sound: Path, change: Callable[[Path], None]) -> None:
    change(sound)
    with pytest.raises(DataError, match="not a file"):
        ResultStore(sound)
