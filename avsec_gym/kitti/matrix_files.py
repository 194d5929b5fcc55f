"""Text files of named matrices, a line ``name: numbers`` each: KITTI's calibration files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.storage.plain_numbers import plain_number
from avsec_gym.storage.text_files import read_text

MatrixShape = tuple[int, ...]
_LARGEST_NUMBER = 1e9
_AGAIN = "Correct the line, or fetch the file again."


@dataclass(frozen=True)
class MatrixFile:
    """The matrices of a file, and the lines that they stand in."""

    path: str | Path
    matrices: dict[str, Floats] = field(default_factory=dict)
    lines: dict[str, int] = field(default_factory=dict)

    def require(self, names: Sequence[str], remedy: str) -> None:
        """Check that matrices are there.

        Raises:
            DataError: One is not.
        """
        missing = [name for name in names if name not in self.matrices]
        if missing:
            raise DataError(
                f"The calibration lacks {', '.join(missing)}.",
                path=self.path,
                line=max(self.lines.values(), default=0) + 1,
                remedy=remedy,
            )


def read_matrices(
    path: str | Path,
    shape_of: Callable[[str], MatrixShape | None],
    aliases: Mapping[str, str] | None = None,
) -> MatrixFile:
    """The matrices of a file; the colon after a name may lack.

    Args:
        path: The file.
        shape_of: The shape of a matrix by its name; None leaves a line alone.
        aliases: Names that stand for others.

    Raises:
        DataError: A matrix stands twice or has the wrong number of entries, or a value is not a
            finite number.
    """
    file = MatrixFile(path)
    for number, line in enumerate(read_text(path).split("\n"), start=1):
        words = line.split()
        if not words:
            continue
        name = words[0].removesuffix(":")
        name = (aliases or {}).get(name, name)
        shape = shape_of(name)
        if shape is None:
            continue
        if name in file.matrices:
            raise DataError(
                f"{name} stands in line {file.lines[name]} already.",
                path=path,
                line=number,
                remedy="Keep one of the two.",
            )
        file.matrices[name] = _matrix(name, words[1:], shape, path, number)
        file.lines[name] = number
    return file


def matrix_lines(matrices: Mapping[str, Floats], digits: int) -> str:
    """The text of such a file: that many digits where they are exact, all elsewhere."""
    return "".join(
        f"{name}: {' '.join(_word(value, digits) for value in np.ravel(matrix).tolist())}\n"
        for name, matrix in matrices.items()
    )


def _matrix(name: str, words: list[str], shape: MatrixShape, path: str | Path, line: int) -> Floats:
    count = int(np.prod(shape))
    if len(words) != count:
        raise DataError(
            f"{name} has {count} entries, this one {len(words)}.",
            path=path,
            line=line,
            remedy="The line may be cut off; fetch the file again.",
        )
    try:
        values = np.array([plain_number(word) for word in words])
    except ValueError as error:
        raise DataError(
            f"{name} holds something that is not a number ({error}).",
            path=path,
            line=line,
            remedy=_AGAIN,
        ) from error
    if not np.abs(values).max() <= _LARGEST_NUMBER:  # Also false for NaN.
        raise DataError(
            f"{name} holds a number that is not finite or too large to be true.",
            path=path,
            line=line,
            remedy=_AGAIN,
        )
    return values.reshape(shape)


def _word(value: float, digits: int) -> str:
    short = f"{value:.{digits - 1}e}"
    return short if float(short) == value else repr(value)
