"""The tables of ``results.sqlite``; ``docs/runs.md`` explains them."""

from __future__ import annotations

VERSIONS = (1, 2, 3)
"""``PRAGMA user_version``: those that are read.  The first had no digests, the second none of
``needs``; both have names that changed since, see `avsec_gym.runs.renamed`."""
VERSION = VERSIONS[-1]

ADDED = {("drives", "swept_collision"): "INTEGER"}
"""Columns that folders of earlier releases lack, by table and name: NULL there, and added where
such a run goes on.  They need no other version: older releases read them, too."""

SCHEMA = """
CREATE TABLE needs (
    experiment TEXT NOT NULL,
    cell TEXT NOT NULL,
    PRIMARY KEY (experiment, cell)
) STRICT;
CREATE TABLE cells (
    cell TEXT PRIMARY KEY,
    work TEXT NOT NULL,
    arguments TEXT NOT NULL,
    status TEXT NOT NULL CHECK (status IN ('done', 'failed')),
    error TEXT,
    seconds REAL NOT NULL,
    finished TEXT NOT NULL
) STRICT;
CREATE TABLE drives (
    cell TEXT NOT NULL REFERENCES cells ON DELETE CASCADE,
    setting TEXT NOT NULL,
    strength REAL NOT NULL,
    scenario TEXT NOT NULL,
    intention TEXT NOT NULL,
    planner TEXT NOT NULL,
    outcome TEXT NOT NULL CHECK (outcome IN ('safe', 'collision', 'unplanned')),
    cost REAL,
    expanded INTEGER NOT NULL,
    path_length REAL,
    travel_time REAL,
    reason TEXT,
    goal_occupied REAL,
    collision_time REAL,
    collision_object INTEGER,
    sm1_cost REAL,
    swept_collision INTEGER,
    planned INTEGER NOT NULL AS (outcome <> 'unplanned'),
    collision INTEGER NOT NULL AS (outcome = 'collision'),
    safe INTEGER NOT NULL AS (outcome = 'safe'),
    PRIMARY KEY (setting, strength, planner, scenario, intention)
) STRICT;
CREATE TABLE detections (
    cell TEXT NOT NULL REFERENCES cells ON DELETE CASCADE,
    setting TEXT NOT NULL,
    strength REAL NOT NULL,
    scenario TEXT NOT NULL,
    boxes TEXT NOT NULL,
    PRIMARY KEY (setting, strength, scenario)
) STRICT;
CREATE TABLE measurements (
    cell TEXT NOT NULL REFERENCES cells ON DELETE CASCADE,
    setting TEXT NOT NULL,
    strength REAL NOT NULL,
    scenario TEXT NOT NULL,
    name TEXT NOT NULL,
    value REAL,
    PRIMARY KEY (name, setting, strength, scenario)
) STRICT;
CREATE TABLE timings (
    cell TEXT NOT NULL REFERENCES cells ON DELETE CASCADE,
    part TEXT NOT NULL,
    seconds REAL NOT NULL,
    PRIMARY KEY (cell, part)
) STRICT;
"""

DIGESTS = """
CREATE TABLE digests (
    cell TEXT PRIMARY KEY REFERENCES cells ON DELETE CASCADE,
    digest TEXT NOT NULL
) STRICT;
"""
"""Added to the schema by its second version: a digest of all rows of a cell."""

NEEDS_DIGEST = """
CREATE TABLE needs_digest (
    digest TEXT NOT NULL
) STRICT;
"""
"""Added by the third: one row, the digest of all rows of ``needs``."""


def schema(version: int, tables: str = SCHEMA) -> str:
    """The tables of a version.

    Args:
        version: One of `VERSIONS`.
        tables: The tables of the first version, as they were made.
    """
    return tables + "".join((DIGESTS, NEEDS_DIGEST)[: version - 1])
