"""Rows of a run that was made under old names, under those of today (`avsec_gym.runs.renamed`).

The version of a run's schema decides which names are in it.  A run of old names is read through
`show_new_names`, and goes on after `rename_rows`.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping

from avsec_gym.runs.experiment import Cell
from avsec_gym.runs.renamed import EXPERIMENTS, SETTINGS, new_setting, with_new_names
from avsec_gym.storage.json_files import parse_json

_RENAMED_COLUMNS = {
    "needs": {"experiment": "new_experiment(experiment)"},
    "cells": {"arguments": "new_arguments(cell, arguments)"},
    "drives": {"setting": "new_setting(cell, setting)"},
    "detections": {"setting": "new_setting(cell, setting)"},
    "measurements": {"setting": "new_setting(cell, setting)"},
}
"""Columns by table: the columns with names in them, and their values under the new ones."""


def show_new_names(database: sqlite3.Connection) -> None:
    """Let a connection that only reads see a run of old names under the new ones.

    Views of the connection's own stand before the tables: nothing in the file changes.
    """
    _define_functions(database)
    database.execute("PRAGMA temp_store = MEMORY")
    for table, renamed in _RENAMED_COLUMNS.items():
        # table_xinfo lists the columns that SQLite computes, too.
        columns = [row[1] for row in database.execute(f"PRAGMA main.table_xinfo({table})")]
        shown = ", ".join(f"{renamed.get(name, name)} AS {name}" for name in columns)
        database.execute(f"CREATE TEMP VIEW {table} AS SELECT {shown} FROM main.{table}")


def rename_rows(database: sqlite3.Connection) -> None:
    """Give all rows of a run the new names, in the transaction that is open.

    The id of a cell stands for its arguments: where they change, it changes in every table.
    Digests of rows are not computed anew here.
    """
    _define_functions(database)
    database.execute("PRAGMA defer_foreign_keys = ON")
    # 1. Names, while the cells still have the ids that the functions know.
    for table, renamed in _RENAMED_COLUMNS.items():
        for column, value in renamed.items():
            database.execute(f"UPDATE {table} SET {column} = {value} WHERE {column} <> {value}")
    # 2. Ids, of the new arguments.
    stored = database.execute("SELECT cell, work, arguments FROM cells").fetchall()
    ids = [(Cell(work, arguments).id, old) for old, work, arguments in stored]
    database.execute("CREATE TEMP TABLE new_ids (new TEXT, old TEXT PRIMARY KEY)")
    database.executemany(
        "INSERT INTO new_ids VALUES (?, ?)", [(new, old) for new, old in ids if new != old]
    )
    for table in ("cells", "needs", "drives", "detections", "measurements", "timings", "digests"):
        database.execute(
            f"UPDATE {table} SET cell = (SELECT new FROM new_ids WHERE old = cell)"
            " WHERE cell IN (SELECT old FROM new_ids)"
        )
    database.execute("DROP TABLE new_ids")


def _define_functions(database: sqlite3.Connection) -> None:
    """The functions of `_RENAMED_COLUMNS`, which know the experiments that need each cell."""
    needs = database.execute("SELECT cell, experiment FROM main.needs").fetchall()
    by_cell = {cell: SETTINGS[experiment] for cell, experiment in needs if experiment in SETTINGS}

    def setting(cell: str, text: str) -> str:
        return new_setting(text, by_cell.get(cell, {}))

    def arguments(cell: str, text: str) -> str:
        return _new_arguments(text, by_cell[cell]) if cell in by_cell else text

    def experiment(name: str) -> str:
        return EXPERIMENTS.get(name, name)

    database.create_function("new_setting", 2, setting, deterministic=True)
    database.create_function("new_arguments", 2, arguments, deterministic=True)
    database.create_function("new_experiment", 1, experiment, deterministic=True)


def _new_arguments(key: str, renamed: Mapping[str, str]) -> str:
    """The arguments of a cell; damaged ones stay as they are."""
    try:
        arguments = parse_json(key)
    except ValueError:
        return key
    if not isinstance(arguments, dict):
        return key
    return Cell.of("", **with_new_names(arguments, renamed)).key
