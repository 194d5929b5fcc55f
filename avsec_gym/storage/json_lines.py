"""Rows that are kept one by one, as lines of JSON: what was stopped goes on after the last one."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.storage.json_fields import check_fields
from avsec_gym.storage.json_files import parse_json
from avsec_gym.storage.regular_files import append_line, is_there
from avsec_gym.storage.text_files import read_text, write_text

_MOST_BYTES = 2**30


class JsonLines:
    """Rows with an ``id``, a line each; a last line that was cut off is dropped.

    Args:
        path: The file, new or not; None keeps the rows in memory only.
        kind: A `typing.TypedDict`: the fields that whoever reads the rows relies on.

    Raises:
        DataError: Another line is damaged, or lacks one of the fields, or has something else there.
    """

    def __init__(self, path: Path | None, kind: type[Any]) -> None:
        self.rows: dict[str, dict[str, Any]] = {}
        self._path = path
        if path is None:
            return
        # What follows the last line break was cut off.
        lines = read_text(path, most=_MOST_BYTES).split("\n")[:-1] if is_there(path) else []
        for number, line in enumerate(lines, start=1):
            row = _row(line, number, path, kind)
            self.rows[row["id"]] = row
        write_text(path, "".join(line + "\n" for line in lines), overwrite=True)

    def add(self, row: dict[str, Any]) -> None:
        """Keep a row, at once."""
        if self._path is not None:
            append_line(self._path, json.dumps(row, allow_nan=False))
        self.rows[row["id"]] = row


def _row(line: str, number: int, path: Path, kind: type[Any]) -> dict[str, Any]:
    """The row of a line, or why it is none."""
    try:
        row = parse_json(line)
        if not (isinstance(row, dict) and isinstance(row.get("id"), str)):
            raise ValueError("it has no id")
        check_fields(kind, row)
    except ValueError as error:
        raise DataError(
            f"Line {number} is damaged ({error}).",
            path=path,
            remedy="Take the line out: what it holds is then made again.",
        ) from error
    return row
