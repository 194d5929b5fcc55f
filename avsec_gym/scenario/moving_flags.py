"""Moving flags of labelled objects: a line for each label line, from the top."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.storage.regular_files import is_there, read_text

_FLAGS = {"n": (False, False), "0": (True, False), "1": (True, True), "-1": (True, True)}
"""Flag -> (is an obstacle, moves)."""


def flagged(boxes: Boxes3D, path: Path) -> tuple[Boxes3D, str | None]:
    """Boxes with moving flags, those flagged ``n`` dropped.

    Flags align with the label lines from the top; a missing flag is ``n``, a surplus one is
    dropped.

    Args:
        boxes: Boxes of all lines of the label file.
        path: The flag file.

    Returns:
        The boxes, and a remark where the lengths differ.

    Raises:
        DataError: The file is missing, or a flag is none of n, 0, 1, -1.
    """
    if not is_there(path):
        raise DataError(
            "the moving flags are not there.",
            path=path,
            remedy="Each label file of this folder needs a flag file of the same name.",
        )
    words = read_text(path).split("\n")
    while words and not words[-1].strip():
        words.pop()
    remark = None
    if len(words) != len(boxes):
        remark = (
            f"{path.parent.name}/{path.name}: {len(words)} flags for {len(boxes)} labels;"
            " missing ones count as n, surplus ones are dropped"
        )
    keep, moving = np.zeros(len(boxes), bool), np.zeros(len(boxes), bool)
    for i, word in enumerate(words):
        if word.strip() not in _FLAGS:
            raise DataError(
                f"{word.strip()[:40]!r} is no moving flag.",
                path=path,
                line=i + 1,
                remedy="A flag is n (no obstacle), 0 (stands), 1 or -1 (moves).",
            )
        if i < len(boxes):
            keep[i], moving[i] = _FLAGS[word.strip()]
    return replace(boxes, moving=moving)[keep], remark
