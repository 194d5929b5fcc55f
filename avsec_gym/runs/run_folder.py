"""The results of a run, read from its folder; also while it is still going on."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.runs.catalogue import EXPERIMENTS, experiment
from avsec_gym.runs.experiment import Configuration, EpisodeRow, Measurement, check_options
from avsec_gym.runs.manifest import MANIFEST, Manifest, read_manifest
from avsec_gym.runs.read_rows import (
    MEASURED,
    FinishedCell,
    episodes_from,
    measurements_from,
)
from avsec_gym.runs.renamed import check_setting
from avsec_gym.runs.renamed_rows import show_new_names
from avsec_gym.runs.run import FIGURES, RESULTS
from avsec_gym.runs.schema import VERSION
from avsec_gym.runs.soundness import (
    check_files,
    check_sound,
    checked_as_it_lies,
    is_written,
    no_sqlite_errors,
    schema_version,
    uri,
)
from avsec_gym.runs.stored_boxes import boxes_from_text
from avsec_gym.storage.json_files import parse_json
from avsec_gym.storage.regular_files import is_there

if TYPE_CHECKING:
    from avsec_gym.metrics.safety import SafetyRecord

_REMEDY = "Name the folder that `avsec run` wrote with --out."


@dataclass(frozen=True)
class RunFolder:
    """A run; `open` makes one.

    Rows come as what cells gave for them, sorted by everything but their values: their order does
    not depend on the order in which cells were finished.  They are chosen by values of columns,
    which ``docs/runs.md`` lists.
    """

    path: Path
    manifest: Manifest

    @classmethod
    def open(cls, path: str | Path) -> RunFolder:
        """The run in a folder.

        Raises:
            DataError: There is none, its results are damaged or of another version, or its options
                are none that `avsec run` takes.
        """
        path = Path(path)
        manifest = read_manifest(path)
        if manifest is None or not is_there(path / RESULTS):
            raise DataError("There is no run here.", path=path, remedy=_REMEDY)
        _check_options(manifest, path)
        run = cls(path, manifest)
        check_files(path / RESULTS)
        if checked_as_it_lies(path / RESULTS) is None:
            with run._database() as database:
                check_sound(database, path / RESULTS)
        return run

    @property
    def configuration(self) -> Configuration:
        """What the run was asked for."""
        return Configuration(**self.manifest["configuration"])

    @property
    def experiments(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(self.manifest["experiments"])

    @property
    def figures(self) -> Path:
        """The folder for pictures of the results."""
        return self.path / FIGURES

    def use_its_threads(self) -> None:
        """Let this process compute with as many threads as the run.

        The last digits of gradients depend on it.
        """
        import torch

        torch.set_num_threads(self.manifest["threads"])

    def cells(self, experiment: str | None = None) -> list[FinishedCell]:
        """Finished cells, of one experiment or all."""
        rows = self._rows(
            "SELECT cell, work, arguments, status, error, seconds, finished FROM cells"
            " WHERE ?1 IS NULL OR cell IN (SELECT cell FROM needs WHERE experiment = ?1)"
            " ORDER BY work, arguments",
            [experiment],
        )
        return [
            FinishedCell(cell, work, self._arguments(arguments), *end)
            for cell, work, arguments, *end in rows
        ]

    def failures(self, experiment: str | None = None) -> list[FinishedCell]:
        """The failures of `cells`."""
        return [cell for cell in self.cells(experiment) if cell.failed]

    def missing(self, experiment: str | None = None) -> int:
        """How many cells are not finished yet."""
        rows = self._rows(
            "SELECT count(DISTINCT cell) FROM needs"
            " WHERE (?1 IS NULL OR experiment = ?1) AND cell NOT IN (SELECT cell FROM cells)",
            [experiment],
        )
        return int(rows[0][0])

    def settings(self) -> list[tuple[str, float]]:
        """Every setting and strength that something was driven or detected under."""
        return self._rows(
            "SELECT setting, strength FROM drives UNION SELECT setting, strength FROM detections"
            " ORDER BY setting, strength"
        )

    def episodes(self, **where: Any) -> list[EpisodeRow]:
        """Episodes: rows of the table ``drives``, whose name is part of the file's format.

        Args:
            where: Values of columns, such as ``setting="dsgn", strength=4, planner="astar"``.
        """
        order = "setting, strength, planner, scenario, intention"
        return episodes_from(self._table("drives", "*", order, where, sqlite3.Row))

    def records(self, **where: Any) -> list[SafetyRecord]:
        """The records of `episodes`; of two settings they are in one order, fit for paired tests.

        Args:
            where: The columns as of `episodes`: setting, strength and planner at least, or they
                stand one after the other.
        """
        return [row.record for row in self.episodes(**where)]

    def detections(self, setting: str, strength: float = 0.0) -> dict[str, Boxes3D]:
        """Boxes by scenario."""
        where = {"setting": setting, "strength": strength}
        rows = self._table("detections", "scenario, boxes", "scenario", where)
        return {scenario: boxes_from_text(boxes, self.path / RESULTS) for scenario, boxes in rows}

    def measurements(self, **where: Any) -> list[Measurement]:
        """Other numbers.

        Args:
            where: Values of columns, such as ``name="loss"``.
        """
        order = "name, setting, strength, scenario"
        return measurements_from(self._table("measurements", MEASURED, order, where))

    def timings(self) -> dict[str, dict[str, float]]:
        """The time of each part: how many cells took it (``cells``), and all ``seconds``."""
        rows = self._rows(
            "SELECT part, count(*), sum(seconds) FROM timings GROUP BY part ORDER BY part"
        )
        return {part: {"cells": cells, "seconds": seconds} for part, cells, seconds in rows}

    def _arguments(self, text: str) -> dict[str, Any]:
        try:
            arguments = parse_json(text)
        except ValueError as error:
            arguments = error
        if not isinstance(arguments, dict):
            raise DataError(
                f"The arguments of a cell are damaged ({arguments!r:.80}).",
                path=self.path / RESULTS,
                remedy=_REMEDY,
            )
        return arguments

    def _table(
        self,
        name: str,
        columns: str,
        order: str,
        where: dict[str, Any],
        row_factory: type[sqlite3.Row] | None = None,
    ) -> list[Any]:
        conditions = " AND ".join(f"{column} IS ?" for column in where) or "TRUE"
        query = f"SELECT {columns} FROM {name} WHERE {conditions} ORDER BY {order}"
        rows = self._rows(query, list(where.values()), row_factory)
        asked = where.get("setting")
        if not rows and asked and asked not in {setting for setting, _ in self.settings()}:
            check_setting(asked, self.experiments)
        return rows

    def _rows(
        self,
        query: str,
        values: Sequence[Any] = (),
        row_factory: type[sqlite3.Row] | None = None,
    ) -> list[Any]:
        """Rows as plain tuples, the quickest to unpack, unless they are to know their columns."""
        with self._database() as database:
            if schema_version(database) < VERSION:
                show_new_names(database)
            database.row_factory = row_factory
            return database.execute(query, values).fetchall()

    @contextmanager
    def _database(self) -> Iterator[sqlite3.Connection]:
        results = self.path / RESULTS
        with no_sqlite_errors(results, "read"), closing(_connected(results)) as database:
            yield database


def _connected(path: Path) -> sqlite3.Connection:
    """For reading.

    A log with something in it is left as it is.  Else the connection is one that may write, though
    nothing is written: only such a one takes SQLite's files beside the database away again.

    In a folder that may not be written, SQLite cannot coordinate with a writer, and there is none.
    """
    mode = "ro" if is_written(path) else "rw"
    database = sqlite3.connect(f"{uri(path)}?mode={mode}", uri=True)
    try:
        database.execute("PRAGMA user_version")
    except sqlite3.OperationalError:
        database.close()
        database = sqlite3.connect(f"{uri(path)}?immutable=1", uri=True)
    return database


def _check_options(manifest: Manifest, folder: Path) -> None:
    """Refuse options that no run of these experiments can have: reports compute with them.

    Only the package's own experiments are asked: nothing else that a folder names is imported.

    Raises:
        DataError: A value is of another type than `avsec run --options` takes.
    """
    defaults: dict[str, Any] = {}
    for name in manifest["experiments"]:
        defaults |= experiment(name).options if name in EXPERIMENTS else {}
    try:
        check_options(manifest["configuration"]["options"], defaults)
    except ConfigurationError as error:
        raise DataError(
            f"This is no manifest of a run: {error}.",
            path=folder / MANIFEST,
            remedy="Correct it, or run the experiment anew.",
        ) from error
