"""Labels of the KITTI tracking benchmark: a file for each sequence, an object a line.

A line holds frame, track, and the 15 columns of the object benchmark (see `labels`), of which
truncation is a level: 0 none, 1 partly, 2 largely.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.kitti.labels import DONT_CARE, label_lines, parse_labels
from avsec_gym.storage.text_files import read_text, write_text

_COLUMNS = 17
_INTEGER = re.compile(r"-1|[0-9]{1,9}")


@dataclass(frozen=True, eq=False)
class TrackedBoxes:
    """The objects of one frame and who they are."""

    boxes: Boxes3D
    """Boxes as `read_labels` gives them; truncation is 0 or, where its share is unknown, -1."""
    tracks: NDArray[np.int64]
    """The same number in all frames of one object, shape (N,); -1 for ``DontCare``."""


def read_tracking_labels(
    path: str | Path, *, keep_dont_care: bool = False
) -> dict[int, TrackedBoxes]:
    """Ground truth of a sequence by frame number, sorted.

    Args:
        path: Label file, such as ``training/label_02/0000.txt``.
        keep_dont_care: Whether DontCare lines are kept, as for `read_labels`.

    Returns:
        The frames that the file names; one with nothing but ``DontCare`` regions has no boxes.

    Raises:
        DataError: A line is not what KITTI promises, or a track is twice in a frame.
    """
    rest: list[str] = []
    numbers: dict[tuple[int, int], int] = {}
    frames, tracks = [], []
    for number, line in enumerate(read_text(path).rstrip().split("\n"), start=1):
        words = line.split()
        if not words and number == 1:
            break
        frame, track = _frame_and_track(words, path, number)
        if track >= 0 and numbers.setdefault((frame, track), number) != number:
            raise DataError(
                f"Track {track} of frame {frame} stands in line {numbers[frame, track]} already.",
                path=path,
                line=number,
                remedy="Remove one of the two lines.",
            )
        rest.append(" ".join(words[2:]))
        frames.append(frame)
        tracks.append(track)
    boxes = parse_labels("\n".join(rest), path, keep_dont_care=True, columns_before=2)
    assert boxes.truncation is not None, "labels have it"
    # Its levels are no shares of the object.
    boxes = replace(boxes, truncation=np.where(boxes.truncation > 0, -1.0, boxes.truncation))
    wanted = np.full(len(boxes), True) if keep_dont_care else boxes.category != DONT_CARE
    every, identities = np.array(frames, np.int64), np.array(tracks, np.int64)
    result = {}
    for frame in sorted(set(frames)):
        here = wanted & (every == frame)
        result[frame] = TrackedBoxes(boxes[here], identities[here])
    return result


def write_tracking_labels(
    path: str | Path, frames: Mapping[int, TrackedBoxes], *, overwrite: bool = False
) -> None:
    """Write the ground truth of a sequence.

    Args:
        path: Label file, such as ``training/label_02/0000.txt``.
        frames: The objects by frame; a share of truncation has no level and is not written.
        overwrite: Whether a file that is there is replaced.

    Raises:
        DataError: The file exists and `overwrite` is false, or cannot be written.
    """
    lines = []
    for frame, tracked in sorted(frames.items()):
        boxes = replace(tracked.boxes, truncation=None)
        for track, line in zip(tracked.tracks.tolist(), label_lines(boxes), strict=True):
            lines.append(f"{frame} {track} {line}\n")
    write_text(path, "".join(lines), overwrite=overwrite)


def _frame_and_track(words: list[str], path: str | Path, number: int) -> tuple[int, int]:
    problem = ""
    if len(words) != _COLUMNS:
        problem = f"A tracking label has {_COLUMNS} columns, this line {len(words)}."
    elif not (_INTEGER.fullmatch(words[0]) and _INTEGER.fullmatch(words[1]) and words[0] != "-1"):
        problem = f"Frame and track are whole numbers, here {' '.join(words[:2])[:40]!r}."
    if problem:
        raise DataError(
            problem,
            path=path,
            line=number,
            remedy="The file may be cut off, or of another benchmark; fetch it again.",
        )
    return int(words[0]), int(words[1])
