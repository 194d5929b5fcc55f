"""What commands share: progress, tables, JSON and exit codes."""

from __future__ import annotations

import json
import sys
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from avsec_gym.errors import AvsecError
from avsec_gym.json_schemas import with_schema

DONE, BAD_DATA, BAD_USAGE, DONE_IN_PART = 0, 1, 2, 3
"""Exit codes."""
CUT_OFF = 141
"""The exit code where the reader of the output has left: what a shell shows of SIGPIPE."""


def print_json(schema: str, value: Mapping[str, Any]) -> None:
    """Write one JSON document to standard output.

    Args:
        schema: One of `SCHEMAS`, which the document names.
        value: The document.
    """
    document = with_schema(schema, value)
    sys.stdout.write(json.dumps(document, indent=1, allow_nan=False) + "\n")


def print_json_line(schema: str, value: Mapping[str, Any]) -> None:
    """Write one JSON line to standard output, at once; arguments as above."""
    sys.stdout.write(json.dumps(with_schema(schema, value), allow_nan=False) + "\n")
    sys.stdout.flush()


def print_line(text: str) -> None:
    """A line of the result, on standard output, at once."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def say(text: str) -> None:
    """A remark for people, on standard error."""
    sys.stderr.write(text + "\n")


def complain(error: AvsecError) -> None:
    """An error for people, on standard error."""
    say(f"avsec: {error}")


class ProgressDisplay:
    """Shows on standard error how far a job is and how long it still takes, after two seconds."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._begun = time.monotonic()
        self._bar: Any = None
        self._task: Any = None
        self._reports: deque[tuple[float, int]] = deque(maxlen=6)
        self._shown = 0.0

    def __call__(self, done: int, total: int) -> None:
        """So much of so much is done."""
        now = time.monotonic()
        if now - self._begun < 2.0 or now - self._shown < 0.1:
            return
        self._shown = now
        if not sys.stderr.isatty():
            if not self._reports:
                self._reports.append((now, done))
            elif now - self._reports[-1][0] > 10.0:
                # By the pace of the last minute: what was there already took no time.
                then, before = self._reports[0]
                left = (now - then) / max(done - before, 1) * (total - done)
                self._reports.append((now, done))
                say(f"{self._what}: {done} of {total}, about {left:.0f} s left")
            return
        if self._bar is None:
            from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            self._bar = Bar(
                TextColumn("{task.description}"),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
                console=_rich_console(stderr=True),
                transient=True,
            )
            self._bar.start()
            self._task = self._bar.add_task(self._what)
        self._bar.update(self._task, completed=done, total=total)

    def close(self) -> None:
        """Take the bar away."""
        if self._task is not None:
            self._bar.stop()


@contextmanager
def progress(what: str) -> Iterator[ProgressDisplay]:
    """A `ProgressDisplay` that goes away in the end."""
    shown = ProgressDisplay(what)
    try:
        yield shown
    finally:
        shown.close()


def print_table(title: str, columns: list[str], rows: list[list[str]]) -> None:
    """A table for people, on standard output; names left, numbers right."""
    from rich.markup import escape
    from rich.table import Table

    # Units in square brackets, and folders so named, are no markup: they are escaped.
    table = Table(header_style="bold")
    for index, column in enumerate(columns):
        numeric = bool(rows) and all(row[index][:1] in "0123456789-–+" for row in rows)
        table.add_column(escape(column), justify="right" if numeric else "left")
    for row in rows:
        table.add_row(*map(escape, row))
    width = None if sys.stdout.isatty() else 140
    console = _rich_console(width=width)
    console.print(escape(title), style="bold", highlight=False)
    if rows:
        console.print(table)


def percent(rate: float | None, interval: list[float] | None = None) -> str:
    """A rate for people: ``94.0 (91.8–95.6)``; a dash where there is no case."""
    if rate is None:
        return "–"
    text = f"{100 * rate:.1f}"
    return text if interval is None else f"{text} ({100 * interval[0]:.1f}–{100 * interval[1]:.1f})"


def _rich_console(**settings: Any) -> Any:
    """A console of rich's that leaves a broken pipe to the command line, as all other output."""
    from rich.console import Console

    class CutOffConsole(Console):
        def on_broken_pipe(self) -> None:
            raise  # What rich is handling; its own exit code would be 1, that of bad data.

    return CutOffConsole(**settings)
