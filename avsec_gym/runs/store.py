"""``results.sqlite`` while a run writes it: a cell is in it with all its rows, or not at all."""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.runs.cell_worker import Done, Failed
from avsec_gym.runs.experiment import Cell
from avsec_gym.runs.renamed_rows import rename_rows
from avsec_gym.runs.schema import ADDED, DIGESTS, NEEDS_DIGEST, VERSION, schema
from avsec_gym.runs.soundness import (
    MAX_RESULTS_BYTES,
    as_text,
    check_files,
    check_not_empty,
    check_sound,
    checked_as_it_lies,
    digests,
    gone,
    needs_digest,
    no_sqlite_errors,
    row_digest,
    schema_version,
    stored_columns,
)
from avsec_gym.storage.regular_files import check_regular, is_there

_BAD_ROWS = (sqlite3.IntegrityError, sqlite3.InterfaceError, sqlite3.ProgrammingError)
_REMEDY = "Name another folder with --out, or remove this one."


class ResultStore:
    """The only writer of a run's results; readers may look on.

    Args:
        path: The database, made if it is not there; one of an earlier version is brought up to
            date.
        begun: Whether the run has been worked on: then the results have to be there.

    Raises:
        DataError: It is not one of a run, is damaged, or cannot be written; or the run has begun
            and there are none, or a link leads to none.
    """

    def __init__(self, path: Path, *, begun: bool = False) -> None:
        self._path = path
        version = None
        if is_there(path):
            check_files(path)
            if check_regular(path, most=MAX_RESULTS_BYTES):
                version = checked_as_it_lies(path)
        elif begun or os.path.islink(path):  # Nothing is made where they are to be put back.
            raise gone(path)
        with no_sqlite_errors(path, "opened"):
            self._database = sqlite3.connect(path)
        try:
            self._open(begun, version)
        except DataError:
            self._database.close()
            raise

    def _open(self, begun: bool, version: int | None) -> None:
        """Go on with the database, or begin it; the version is None where it is to be checked."""
        with no_sqlite_errors(self._path, "opened"):
            if schema_version(self._database) == 0:
                if begun:
                    check_not_empty(self._database, self._path)
                if self._database.execute("SELECT 1 FROM sqlite_master").fetchone():
                    raise DataError(
                        "This is a database of something else.", path=self._path, remedy=_REMEDY
                    )
                self._database.execute("PRAGMA journal_mode = WAL")
                self._database.executescript(f"BEGIN; {schema(VERSION)}")
                self._note_needs()
                self._database.execute(f"PRAGMA user_version = {VERSION}")
                self._database.commit()
            if version is None:
                version = check_sound(self._database, self._path)
            self._database.execute("PRAGMA journal_mode = WAL")
            # A killed process loses nothing; a power failure perhaps the last cells.
            self._database.execute("PRAGMA synchronous = NORMAL")
            self._database.execute("PRAGMA foreign_keys = ON")
            if version < VERSION:
                self._bring_up_to_date(version)

    def _bring_up_to_date(self, version: int) -> None:
        """Make a database of an earlier version one of this version, or leave it as it was."""
        if version == 1:
            self._add_columns()
        self._database.execute("BEGIN")
        if version == 1:
            self._database.execute(DIGESTS)
        rename_rows(self._database)
        self._database.execute("DELETE FROM digests")
        self._database.executemany(
            "INSERT INTO digests VALUES (?, ?)", digests(self._database).items()
        )
        self._database.execute(NEEDS_DIGEST)
        self._note_needs()
        self._database.execute(f"PRAGMA user_version = {VERSION}")
        self._database.commit()

    def _note_needs(self) -> None:
        """Let the digest of ``needs`` be that of the rows that are there."""
        self._database.execute("DELETE FROM needs_digest")
        self._database.execute(
            "INSERT INTO needs_digest VALUES (?)", (needs_digest(self._database),)
        )

    def _add_columns(self) -> None:
        """Let a run of an earlier release go on."""
        for (table, name), kind in ADDED.items():
            columns = {row[1] for row in self._database.execute(f"PRAGMA table_info({table})")}
            if name not in columns:
                self._database.execute(f"ALTER TABLE {table} ADD COLUMN {name} {kind}")

    def close(self) -> None:
        """Fold the write-ahead log into the file."""
        self._database.close()

    def statuses(self) -> dict[str, str]:
        """``done`` or ``failed`` of each finished cell, by its id."""
        with no_sqlite_errors(self._path, "read"):
            return dict(self._database.execute("SELECT cell, status FROM cells").fetchall())

    def plan(self, needs: Mapping[str, Sequence[Cell]], known: Iterable[str]) -> None:
        """Note which cells experiments need; what others need stays.

        Args:
            needs: The cells by experiment.
            known: All experiments of the run.

        Raises:
            DataError: No experiment would then need the finished cells.
        """
        with self._transaction():
            others = json.dumps(sorted(set(known) - set(needs)))
            self._database.execute(
                "DELETE FROM needs WHERE experiment NOT IN (SELECT value FROM json_each(?))",
                (others,),
            )
            for experiment, cells in needs.items():
                self._database.executemany(
                    "INSERT INTO needs VALUES (?, ?)", [(experiment, cell.id) for cell in cells]
                )
            self._note_needs()
            orphans = self._database.execute(
                "SELECT work, arguments FROM cells WHERE cell NOT IN (SELECT cell FROM needs)"
            ).fetchall()
            if orphans:
                raise DataError(
                    f"{len(orphans)} finished cells here are no longer asked for, such as"
                    f" {' '.join(orphans[0])}: the experiments have changed.",
                    path=self._path,
                    remedy=_REMEDY,
                )

    def forget_failures(self, cells: Iterable[Cell]) -> None:
        """Let failed ones among these cells count as not done."""
        with self._transaction():
            self._database.executemany(
                "DELETE FROM cells WHERE cell = ? AND status = 'failed'",
                [(cell.id,) for cell in cells],
            )

    def add(self, cell: Cell, outcome: Done | Failed) -> Done | Failed:
        """Store a finished cell.

        Returns:
            The outcome; a failure where rows of the result do not fit, such as episodes that
            another cell has filed under the same setting.

        Raises:
            DataError: The file cannot be written.
        """
        try:
            self._insert(cell, outcome)
        except _BAD_ROWS as error:
            outcome = Failed(f"Its rows cannot be stored: {error}", seconds=outcome.seconds)
            self._insert(cell, outcome)
        return outcome

    def _insert(self, cell: Cell, outcome: Done | Failed) -> None:
        error = outcome.error if isinstance(outcome, Failed) else None
        finished: dict[str, Any] = {
            "work": cell.work,
            "arguments": cell.key,
            "status": "done" if error is None else "failed",
            "error": error,
            "seconds": outcome.seconds,
            "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        }
        tables = {"cells": [finished]} | (outcome.rows if isinstance(outcome, Done) else {})
        with self._transaction():
            total = 0
            for table, rows in tables.items():
                stored = ", ".join(stored_columns()[table])
                for row in rows:
                    names, marks = ", ".join(["cell", *row]), ", ".join("?" * (len(row) + 1))
                    place = self._database.execute(
                        f"INSERT INTO {table} ({names}) VALUES ({marks})", [cell.id, *row.values()]
                    ).lastrowid
                    # As the table keeps it: a 1 in a column of real numbers is 1.0.
                    kept = self._database.execute(
                        f"SELECT {stored} FROM {table} WHERE rowid = ?", [place]
                    ).fetchone()
                    total += row_digest(table, kept)
            self._database.execute("INSERT INTO digests VALUES (?, ?)", [cell.id, as_text(total)])

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """All or nothing."""
        try:
            with self._database:
                yield
        except _BAD_ROWS:
            raise
        except sqlite3.Error:
            with no_sqlite_errors(self._path, "written"):
                raise


def has_results(path: Path, *, begun: bool = False) -> bool:
    """Whether a cell is finished in a run's database; not if there is none.

    Args:
        path: The path of the database.
        begun: Whether the run has been worked on, as of `ResultStore`.

    Raises:
        DataError: As of `ResultStore`.
    """
    if not (begun or os.path.lexists(path)):
        return False
    with closing(ResultStore(path, begun=begun)) as store:
        return bool(store.statuses())
