"""Boxes as one line of JSON, with every digit that a float32 has."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.json_files import parse_json


def boxes_to_text(boxes: Boxes3D) -> str:
    """JSON: the fields of `Boxes3D` that are known, each a list with an entry for each box.

    Numbers have nine significant digits.
    """
    columns: dict[str, Any] = {}
    for column in fields(Boxes3D):
        value = getattr(boxes, column.name)
        if value is not None:
            numeric = np.issubdtype(value.dtype, np.floating)
            columns[column.name] = _short(value.tolist()) if numeric else value.tolist()
    return json.dumps(columns, separators=(",", ":"))


def boxes_from_text(text: str, path: str | Path | None = None) -> Boxes3D:
    """The boxes again.

    Args:
        text: The text of `boxes_to_text`.
        path: The file that it is in, for messages.

    Raises:
        DataError: It is no such text.
    """
    try:
        columns = parse_json(text)
        if not isinstance(columns, dict) or "rotation_y" not in columns:
            raise ValueError("no boxes are in it")
        count = np.size(columns["rotation_y"])
        for name, width in (("location", 3), ("dimensions", 3), ("box2d", 4)):
            if name in columns:
                columns[name] = np.reshape(columns[name], (count, width))
        return Boxes3D(**columns)
    except (TypeError, ValueError, OverflowError, ConfigurationError) as error:
        raise DataError(
            f"Stored boxes are damaged ({error}).",
            path=path,
            remedy="Run the experiments again, in another folder.",
        ) from error


def _short(value: Any) -> Any:
    return [_short(item) for item in value] if isinstance(value, list) else float(f"{value:.9g}")
