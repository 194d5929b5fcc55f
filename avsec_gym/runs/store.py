"""``results.sqlite`` while a run writes it: a cell is in it with all its rows, or not at all."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.experiments.experiment import Cell
from avsec_gym.runs.desk import Done, Failed
from avsec_gym.runs.schema import ADDED, SCHEMA, VERSION

_BAD_ROWS = (sqlite3.IntegrityError, sqlite3.InterfaceError, sqlite3.ProgrammingError)
_REMEDY = "Name another folder with --out, or remove this one."


class ResultStore:
    """The only writer of a run's results; readers may look on.

    Args:
        path: Of the database, made if it is not there.

    Raises:
        DataError: It is not one of a run, or cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._database = sqlite3.connect(path)
            self._database.execute("PRAGMA journal_mode = WAL")
            # A killed process loses nothing; a power failure perhaps the last cells.
            self._database.execute("PRAGMA synchronous = NORMAL")
            self._database.execute("PRAGMA foreign_keys = ON")
            if schema_version(self._database) == 0:
                self._database.executescript(
                    f"BEGIN; {SCHEMA} PRAGMA user_version = {VERSION}; COMMIT;"
                )
            there = schema_version(self._database)
            if there == VERSION:
                self._add_columns()
        except sqlite3.Error as error:
            raise self._cannot("opened", error) from error
        if there != VERSION:
            raise DataError(
                f"The results have schema {there}, this version writes {VERSION}.",
                path=path,
                remedy=_REMEDY,
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
        return dict(self._database.execute("SELECT cell, status FROM cells").fetchall())

    def plan(self, needs: Mapping[str, Sequence[Cell]], known: Iterable[str]) -> None:
        """Note which cells experiments need; what others need stays.

        Args:
            needs: By experiment.
            known: All experiments of the run.

        Raises:
            DataError: Finished cells would then be needed by nobody.
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
            The outcome; a failure where rows of the result do not fit, such as drives that another
            cell has driven under the same setting.

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
            for table, rows in tables.items():
                for row in rows:
                    names, marks = ", ".join(["cell", *row]), ", ".join("?" * (len(row) + 1))
                    self._database.execute(
                        f"INSERT INTO {table} ({names}) VALUES ({marks})", [cell.id, *row.values()]
                    )

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """All or nothing."""
        try:
            with self._database:
                yield
        except _BAD_ROWS:
            raise
        except sqlite3.Error as error:
            raise self._cannot("written", error) from error

    def _cannot(self, what: str, error: sqlite3.Error) -> DataError:
        return DataError(
            f"The results cannot be {what} ({error}).",
            path=self._path,
            remedy="Check the folder's permissions and the free space; a damaged file cannot be"
            " mended, remove the run's folder then.",
        )


def has_results(path: Path) -> bool:
    """Whether a cell is finished in a run's database; not if there is none.

    Raises:
        DataError: It is not one of a run.
    """
    if not path.is_file():
        return False
    with closing(ResultStore(path)) as store:
        return bool(store.statuses())


def schema_version(database: sqlite3.Connection) -> int:
    """Of a database; 0 of a new one."""
    return int(database.execute("PRAGMA user_version").fetchone()[0])
