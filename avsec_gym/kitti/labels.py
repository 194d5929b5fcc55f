"""Label and result files of the KITTI object benchmark, to and from `Boxes3D`.

A line holds one object in 15 columns: category, truncation, occlusion, alpha, 2D box (4),
height, width, length, location (3), rotation_y; a detector's result has a 16th, the score.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NoReturn

import numpy as np

from avsec_gym.boxes import LARGEST_ANGLE, Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats
from avsec_gym.image_only import (
    NOWHERE,
    UNKNOWN_ANGLE,
    UNKNOWN_SIZE,
    image_only_rows,
    is_image_only,
)
from avsec_gym.kitti.label_ranges import all_possible, impossibility
from avsec_gym.storage.text_files import read_text, write_text

DONT_CARE = "DontCare"
"""The category of image regions without labels: a 2D box and placeholders."""

CATEGORIES = frozenset(
    {"Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram", "Misc", DONT_CARE}
)
"""The categories of the benchmark itself; files may hold others."""

LARGEST_NUMBER = 1e6
"""No pixel or score beyond this is believed; for what else cannot be, see `label_ranges`."""

_LABEL_COLUMNS, _RESULT_COLUMNS = 15, 16
_DIMENSIONS, _LOCATION, _ROTATION = slice(7, 10), slice(10, 13), 13
_ANGLES = [2, _ROTATION]
_REMEDY = "Correct the line, or fetch the file again from where it came."
_GROUPED_DIGITS = re.compile(r"[0-9]_[0-9]")


def read_labels(path: str | Path, *, keep_dont_care: bool = False) -> Boxes3D:
    """Ground truth of one frame, in the order of the file's lines.

    Args:
        path: A file of ``label_2``; one without lines is a frame without objects.
        keep_dont_care: Whether the lines of category ``DontCare``, whose dimensions are -1 and
            whose locations are -1000, are kept, so that box i is line i + 1.

    Returns:
        Boxes with every optional field but `moving`; scores are 1.

    Raises:
        DataError: The file or one of its lines is not what KITTI promises.
    """
    return parse_labels(read_text(path), path, keep_dont_care=keep_dont_care)


def parse_labels(
    text: str, path: str | Path, *, keep_dont_care: bool = False, columns_before: int = 0
) -> Boxes3D:
    """What `read_labels` makes of a file's text.

    Args:
        text: Content of the file, with the 15 columns in each line.
        path: Path of the file, for messages.
        keep_dont_care: Whether DontCare lines are kept, as for `read_labels`.
        columns_before: Number of columns that the file has before the 15, for messages.

    Raises:
        DataError: As of `read_labels`.
    """
    names, values = _parse(text, path, _LABEL_COLUMNS, columns_before)
    return _boxes(names, values, keep_dont_care)


def read_detections(path: str | Path) -> Boxes3D:
    """What a detector found in one frame.

    Blank lines, trailing spaces, placeholders (-1, -10) and scores of any range are fine;
    lines of category ``DontCare`` are no detections and are dropped.  A line with a 2D box alone
    (sizes -1, place -1000) becomes a box that is known in the image only, see
    `avsec_gym.image_only`.

    Raises:
        DataError: The file or one of its lines is not what KITTI promises of results.
    """
    names, values = _parse(read_text(path), path, _RESULT_COLUMNS)
    return _boxes(names, values, keep_dont_care=False)


def write_labels(path: str | Path, boxes: Boxes3D, *, overwrite: bool = False) -> None:
    """Write a label file; what KITTI's own files hold comes out byte for byte.

    Two decimals where they are exact, all digits elsewhere.  Scores and moving flags have
    no place in the format.  Unknown fields become KITTI's placeholders, -1 and -10.

    Raises:
        ConfigurationError: A category is not a plain word.
        DataError: The file exists and `overwrite` is false, it cannot be written, or the boxes
            make a file that `read_labels` refuses.
    """
    _write(path, boxes, _LABEL_COLUMNS, overwrite)


def label_lines(boxes: Boxes3D) -> list[str]:
    """The lines of a label file, without line ends; see `write_labels`."""
    return list(_lines(boxes, _LABEL_COLUMNS))


def write_detections(path: str | Path, boxes: Boxes3D, *, overwrite: bool = False) -> None:
    """Write a result file, lossless in every digit; see `write_labels` for errors."""
    _write(path, boxes, _RESULT_COLUMNS, overwrite)


def _parse(
    text: str, path: str | Path, columns: int, columns_before: int = 0
) -> tuple[list[str], Floats]:
    """Categories and the (N, columns - 1) numbers; the slow look happens only on suspicion."""
    content = text.rstrip(" \t\r\n")
    lines = content.split("\n") if content else []
    rows = [line.split() for line in lines]
    if columns == _RESULT_COLUMNS:  # Detectors leave blank lines.
        rows = [row for row in rows if row]
    names = [row[0] for row in rows if row]
    values = _numbers(rows, columns)
    if values is not None and columns == _RESULT_COLUMNS:
        values = _with_places(values)
    if (
        values is None
        or _is_suspicious(text)
        or not CATEGORIES.issuperset(names)
        or not _plausible(names, values, columns, columns_before)
    ):
        for number, line in enumerate(lines, start=1):
            _check_line(line, path, number, columns, columns_before)
    assert values is not None, "where every line is right, so is the whole"
    return names, values


def _with_places(values: Floats) -> Floats:
    """A result's numbers, shape (N, 15), where 2D boxes alone all have the same placeholders."""
    alone = image_only_rows(values[:, _DIMENSIONS], values[:, _LOCATION])
    if alone.any():
        values = values.copy()
        values[alone, _DIMENSIONS] = UNKNOWN_SIZE
        values[alone, _LOCATION] = NOWHERE
        values[alone, _ROTATION] = UNKNOWN_ANGLE
    return values


def _numbers(rows: list[list[str]], columns: int) -> Floats | None:
    try:
        numbers = [list(map(float, row[1:])) for row in rows]
        return np.array(numbers, np.float64).reshape(len(rows), columns - 1)
    except ValueError:
        return None


def _is_suspicious(text: str) -> bool:
    """Whether there may be something that float() and split() accept although no file means it."""
    if not text.isascii() or not text.replace("\n", " ").isprintable():
        return True
    return "_" in text and _GROUPED_DIGITS.search(text) is not None


def _plausible(names: list[str], values: Floats, columns: int, columns_before: int) -> bool:
    if not names:
        return True
    if not np.abs(values).max() <= LARGEST_NUMBER:  # Also false for NaN.
        return False
    if (values[:, 5:7] < values[:, 3:5]).any():
        return False
    if (np.abs(values[:, _ANGLES]) > LARGEST_ANGLE).any():  # Of placeholders, too: they are kept.
        return False
    objects = values[[name != DONT_CARE for name in names]]
    result, tracking = columns == _RESULT_COLUMNS, columns_before > 0
    sized = bool((objects[:, _DIMENSIONS] > 0).all())
    return sized and all_possible(objects, result=result, tracking=tracking)


def _check_line(
    line: str, path: str | Path, number: int, columns: int, columns_before: int
) -> None:
    """Raise the error that names what is wrong with a line, if anything is."""

    def refuse(problem: str, remedy: str = _REMEDY) -> NoReturn:
        raise DataError(problem, path=path, line=number, remedy=remedy)

    # Characters, number of columns, category.
    plain = line.rstrip("\r").replace("\t", " ")
    if not plain.isprintable():
        odd = next(character for character in plain if not character.isprintable())
        refuse(
            f"The line holds the unprintable character {odd!r}.",
            "Save the file as plain UTF-8 text without a byte order mark.",
        )
    row = plain.split()
    if not row:
        if columns != _RESULT_COLUMNS:
            refuse("A blank line stands between objects.", "Remove it: lines are counted.")
        return
    if len(row) != columns:
        refuse(*_wrong_count(row, columns))
    if not _is_name(row[0]):
        refuse(f"The category {row[0][:40]!r} is not a word.")
    # Each number by itself.
    values = []
    for column, word in enumerate(row[1:], start=columns_before + 2):
        value = _number(word)
        if value is None:
            refuse(f"Column {column} holds {word[:40]!r}, which is not a number.")
        elif not np.isfinite(value):
            refuse(f"Column {column} holds {word[:40]!r}, which is not finite.")
        elif abs(value) > LARGEST_NUMBER:
            refuse(f"Column {column} holds {word[:40]!r}, too large to be true.")
        else:
            values.append(value)
    if columns == _RESULT_COLUMNS:
        values = _with_places(np.array([values]))[0].tolist()
    # The numbers together, as an object of the world.
    if row[0] != DONT_CARE and min(values[_DIMENSIONS]) <= 0:
        sizes = " x ".join(row[8:11])
        refuse(
            f"A {row[0]} measures {sizes} m (height x width x length).",
            "Real objects have positive sizes; a result with a 2D box alone has -1 -1 -1.",
        )
    result, tracking = columns == _RESULT_COLUMNS, columns_before > 0
    if row[0] == DONT_CARE:  # Placeholders, but for its 2D box.
        for angle in (values[column] for column in _ANGLES):
            if abs(angle) > LARGEST_ANGLE:
                refuse(f"An angle of a {row[0]} is {angle:g}; it is -10 where there is none.")
        values = [-1.0, -1.0, -10.0, *values[3:7], *[-1.0] * 6, -10.0]
    if problem := impossibility(row[0], values, result=result, tracking=tracking):
        refuse(problem)


def _wrong_count(row: list[str], columns: int) -> tuple[str, str]:
    kind = "label" if columns == _LABEL_COLUMNS else "result"
    problem = f"A {kind} line has {columns} columns, this one has {len(row)}."
    if len(row) in (17, 18) and _number(row[0]) is not None and _number(row[2]) is None:
        return problem, "It looks like a file of the tracking benchmark (frame and track first)."
    if len(row) == _RESULT_COLUMNS and columns == _LABEL_COLUMNS:
        return problem, "It looks like a detector's result: the 16th column would be its score."
    if len(row) == _LABEL_COLUMNS and columns == _RESULT_COLUMNS:
        return problem, "It looks like ground truth: a detector's result ends with a score."
    if len(row) > columns:
        return problem, "It looks like an extended format: leave out the surplus columns."
    return problem, "The file may be cut off; fetch or write it again."


def _number(word: str) -> float | None:
    try:
        return float(word) if word.isascii() and "_" not in word else None
    except ValueError:
        return None


def _is_name(word: str) -> bool:
    return word[:1].isalpha() and word.isprintable() and len(word.split()) == 1


def _boxes(names: list[str], values: Floats, keep_dont_care: bool) -> Boxes3D:
    if not keep_dont_care and DONT_CARE in names:
        values = values[[name != DONT_CARE for name in names]]
        names = [name for name in names if name != DONT_CARE]
    columns = np.ascontiguousarray(values.T)
    return Boxes3D(
        location=values[:, 10:13].copy(),
        dimensions=values[:, _DIMENSIONS].copy(),
        rotation_y=columns[13],
        score=columns[14] if len(columns) > 14 else np.ones(len(names)),
        category=np.array(names, np.str_),
        box2d=values[:, 3:7].copy(),
        truncation=columns[0],
        occlusion=columns[1],
        alpha=columns[2],
    )


def _write(path: str | Path, boxes: Boxes3D, columns: int, overwrite: bool) -> None:
    for name in boxes.category:
        if not _is_name(str(name)):
            raise ConfigurationError(f"a category is a plain word, got {str(name)!r}")
    text = "".join(line + "\n" for line in _lines(boxes, columns))
    _parse(text, path, columns)  # Nothing is written that would be refused when read.
    write_text(path, text, overwrite=overwrite)


def _lines(boxes: Boxes3D, columns: int) -> Iterable[str]:
    count = len(boxes)
    unknown = {"truncation": -1.0, "occlusion": -1.0, "alpha": -10.0, "box2d": -1.0}
    parts = []
    for name, placeholder in unknown.items():
        width, value = 4 if name == "box2d" else 1, getattr(boxes, name)
        if value is None:
            value = np.full(count * width, placeholder)
        parts.append(value.reshape(count, width))
    parts += [boxes.dimensions, boxes.location, boxes.rotation_y[:, None], boxes.score[:, None]]
    short = columns == _LABEL_COLUMNS
    values = np.hstack(parts)[:, : columns - 1]
    alone = is_image_only(boxes)
    if not short:
        values[alone, _DIMENSIONS] = -1.0
    rows = values.tolist()
    for name, row, flat in zip(boxes.category.tolist(), rows, alone.tolist(), strict=True):
        words = [_word(value, short) for value in row]
        # KITTI writes levels and placeholders without decimals.
        placeholders = [1, *(i for i, value in ((0, -1), (2, -10)) if row[i] == value)]
        if name == DONT_CARE or flat:
            placeholders += range(7, 14)
        for i in placeholders:
            if row[i] == int(row[i]):
                words[i] = str(int(row[i]))
        yield " ".join([name, *words])


def _word(value: float, short: bool) -> str:
    two_decimals = f"{value:.2f}"
    return two_decimals if short and float(two_decimals) == value else repr(value)
