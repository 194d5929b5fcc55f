"""A page of all commands: what `avsec COMMAND --help` prints, each under its own heading."""

from __future__ import annotations

import io
import re
from contextlib import redirect_stdout
from pathlib import Path
from unittest.mock import patch

from written_pages import write_changed

from avsec_gym.cli import every_command, run

_HEAD = """# Commands

Each of them states its options, units and defaults by `--help`, as here.  Exit codes: 0 done, 1 bad
data, 2 bad usage, 3 done in part.
"""
_TABLE = re.compile(r"^ .*\n -+\s*\n", re.MULTILINE)
"""The heading of a table of options, with the line below it."""


def write_pages(source: Path) -> set[Path]:
    """Write it; returns the file."""
    text = _HEAD + "".join(f"\n## avsec {words}\n\n{_help(words)}" for words in every_command())
    return {write_changed(source / "commands.md", text.encode())}


def _help(words: str) -> str:
    """The help of a command: usage, what it does in words, and its options without their frame."""
    said = io.StringIO()
    with redirect_stdout(said), patch.dict("os.environ", COLUMNS="88"):
        run([*words.split(), "--help"])
    described, *_ = _TABLE.split(said.getvalue())
    options = said.getvalue()[len(described) :]
    usage, _, what_it_does = described.strip().partition("\n")
    lines = (line.rstrip() for line in options.splitlines() if line.strip("- "))
    shown = "\n".join(lines)
    return f"```text\n{usage}\n```\n{what_it_does.rstrip()}\n\n```text\n{shown}\n```\n"
