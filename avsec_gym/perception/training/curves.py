"""The curves of a training: JSON lines, a picture, and TensorBoard's files if it is installed."""

from __future__ import annotations

import json
import logging
import math
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_fields import fits
from avsec_gym.storage.json_files import parse_json
from avsec_gym.storage.regular_files import append_line, is_there, read_text
from avsec_gym.storage.write_errors import naming

CURVES, PICTURE, TENSORBOARD = "curves.jsonl", "curves.png", "tensorboard"
"""Names in the folder of a run."""

_SECONDS_BETWEEN_PICTURES = 60.0
_MOST_BYTES = 2**30
_LOG = logging.getLogger(__name__)


class Curves:
    """Writes what a training reports.

    Args:
        folder: The folder of the run.
        step: Where it goes on; lines of later steps, of a run that was killed, are dropped.
    """

    def __init__(self, folder: Path, step: int = 0) -> None:
        self._folder = folder
        self._path = folder / CURVES
        kept = [row for row in read_curves(folder) if row["step"] <= step]
        content = "".join(f"{_line(row)}\n" for row in kept)
        write_bytes(self._path, content.encode(), overwrite=True)
        self._board = _tensorboard(folder / TENSORBOARD, step)
        self._drawn = -math.inf

    def add(self, step: int, kind: str, values: Mapping[str, float], **facts: float) -> None:
        """Values at a step.

        Args:
            step: Steps that were done.
            kind: ``losses`` or ``metrics``.
            values: The values by name.
            facts: Facts that are kept beside them, such as the seconds so far.
        """
        append_line(self._path, _line({"step": step, **facts, kind: dict(values)}))
        if self._board is not None:
            with naming(self._folder / TENSORBOARD):
                for name, value in values.items():
                    self._board.add_scalar(f"{kind}/{name}", value, step)
                self._board.flush()

    def draw(self) -> None:
        """Draw all of them, unless that was done just now."""
        if time.monotonic() - self._drawn > _SECONDS_BETWEEN_PICTURES:
            draw_curves(read_curves(self._folder), self._folder / PICTURE)
            self._drawn = time.monotonic()

    def close(self) -> None:
        """Draw what is left to be drawn, close TensorBoard's files."""
        self._drawn = -math.inf
        self.draw()
        if self._board is not None:
            with naming(self._folder / TENSORBOARD):
                self._board.close()


def read_curves(folder: Path) -> list[dict[str, Any]]:
    """The rows of a run's curves; a last line that was cut off is left out.

    Raises:
        DataError: Another line is damaged.
    """
    path = folder / CURVES
    if not is_there(path):
        return []
    rows = []
    lines = read_text(path, most=_MOST_BYTES).split("\n")[:-1]
    for number, line in enumerate(lines, start=1):
        try:
            rows.append(_row(line))
        except ValueError as error:
            raise DataError(
                f"This is no row of curves ({error}).",
                path=path,
                line=number,
                remedy="Remove the line; the checkpoint does not depend on it.",
            ) from error
    return rows


def _row(line: str) -> dict[str, Any]:
    row = parse_json(line, finite=False)
    if not (isinstance(row, dict) and type(row.get("step")) is int):
        raise ValueError("it has no step")
    for kind in ("losses", "metrics"):
        if not fits(row.get(kind, {}), dict[str, float]):
            raise ValueError(f"its {kind} are no numbers")
    return row


def draw_curves(rows: Sequence[Mapping[str, Any]], path: Path) -> None:
    """A picture: loss terms (logarithmic), and metrics beside them where there are any.

    Args:
        rows: The rows of `read_curves`.
        path: A PNG, written over.
    """
    import io

    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    kinds = [kind for kind in ("losses", "metrics") if any(kind in row for row in rows)] or [
        "losses"
    ]
    figure = Figure(figsize=(6 * len(kinds), 4), dpi=110, layout="constrained")
    for axes, kind in zip(figure.subplots(1, len(kinds), squeeze=False)[0], kinds, strict=True):
        chosen = [row for row in rows if kind in row]
        for name in dict.fromkeys(name for row in chosen for name in row[kind]):
            points = [(row["step"], row[kind][name]) for row in chosen if name in row[kind]]
            axes.plot(*zip(*points, strict=True), label=name, linewidth=1.2,
                      marker="." if kind == "metrics" else None)  # fmt: skip
        if kind == "losses":
            # Terms with learned weights may fall below 0.
            axes.set_yscale("symlog", linthresh=0.1)
        axes.set_title(kind, loc="left")
        axes.set_xlabel("steps")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.spines[["top", "right"]].set_visible(False)
        if chosen:
            # Beside the axes: curves may run anywhere in them.
            axes.legend(fontsize=7, frameon=False, loc="upper left", bbox_to_anchor=(1, 1))
    picture = io.BytesIO()
    figure.savefig(picture, format="png")
    write_bytes(path, picture.getvalue(), overwrite=True)


def _tensorboard(folder: Path, step: int) -> Any:
    try:
        from torch.utils.tensorboard import SummaryWriter
    except ImportError:
        _LOG.info("no TensorBoard files: they need the extra `train`")
        return None
    with naming(folder):
        return SummaryWriter(str(folder), purge_step=step + 1 if step else None)


def _line(row: Mapping[str, Any]) -> str:
    return json.dumps(row, allow_nan=True)
