"""Text files of numbers alone, so many in each line: poses, times, measurements."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.storage.plain_numbers import plain_number
from avsec_gym.storage.text_files import read_text

_LARGEST = 1e6
_AGAIN = "The file may be cut off or damaged; fetch it again."


def read_numbers(path: str | Path, columns: int) -> Floats:
    """All numbers of a file, shape (lines, columns).

    Args:
        path: The file.
        columns: How many stand in each line, between spaces.

    Raises:
        DataError: There is no line, a line has another number of words, or one of them is no
            finite number up to a million.
    """
    lines = read_text(path).rstrip().split("\n")
    if lines == [""]:
        raise DataError("There is no number in the file.", path=path, remedy="Fetch it again.")
    table = np.empty((len(lines), columns))
    for i, line in enumerate(lines):
        words = line.split()
        if len(words) != columns:
            problem = f"A line holds {columns} numbers, this one {len(words)}."
            raise DataError(problem, path=path, line=i + 1, remedy=_AGAIN)
        try:
            table[i] = [plain_number(word) for word in words]
        except ValueError as error:
            problem = f"A line holds something that is not a number ({error})."
            raise DataError(problem, path=path, line=i + 1, remedy=_AGAIN) from error
        if not np.abs(table[i]).max() <= _LARGEST:  # Also true for NaN.
            problem = "A line holds a number that is not finite or too large to be true."
            raise DataError(problem, path=path, line=i + 1, remedy=_AGAIN)
    return table
