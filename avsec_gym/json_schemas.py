"""What programs read: every JSON document of a command names its schema, and the schema's version.

``"schema": "avsec.evaluate/1"`` is the first key of each document, and of each line where a command
writes lines.  A version is raised when a key goes, or means something else; new keys may come
without.  docs/runs.md lists them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

SCHEMAS: Mapping[str, int] = {
    "demo": 2,
    "evaluate": 1,
    "detect": 1,
    "ap": 1,
    "ap.report": 1,
    "disparity": 1,
    "attack.patch": 1,
    "validate.frame": 2,
    "validate.summary": 2,
    "connected.instant": 1,
    "connected.drive": 1,
    "connected.summary": 1,
    "experiments": 1,
    "run": 1,
    "report": 2,
    "benchmark.entry": 1,
    "plan": 1,
    "data.check": 1,
    "world.make": 1,
    "world.twin": 1,
    "world.verify": 1,
    "train": 1,
    "agents.train": 1,
    "agents.evaluate": 2,
    "agents.evaluate.budgets": 1,
    "agents.list": 1,
    "hub.export": 1,
    "hub.import": 1,
    "drive": 1,
    "drive.row": 2,
    "error-model.fit": 1,
    "error-model.check": 1,
    "weights.import": 1,
    "weights.calibrate": 1,
}
"""Version by name: the command's words, and what it is where a command writes two."""


def with_schema(name: str, value: Mapping[str, Any]) -> dict[str, Any]:
    """A JSON object with its schema as first key.

    Args:
        name: One of `SCHEMAS`.
        value: The object.

    Example:
        >>> with_schema("evaluate", {"rates": []})
        {'schema': 'avsec.evaluate/1', 'rates': []}
    """
    schema = {"schema": f"avsec.{name}/{SCHEMAS[name]}"}
    return schema | {key: own for key, own in value.items() if key != "schema"}
