"""Commands that make one more page of a finished run: JSON, and Markdown where it is asked for."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.storage.text_files import write_text
from studies.answer import answer

R = TypeVar("R")


def run_page(
    module: str,
    what: str | None,
    arguments: Sequence[str] | None,
    measured: Callable[[RunFolder], R],
    page: Callable[[R, str], str],
) -> int:
    """Parse the command line, measure, print or write.

    Args:
        module: The full name of the module that is run.
        what: Docstring of the module, whose first line is the help.
        arguments: The words of the command line; None: those of the process.
        measured: The function from the run to the result, a dataclass.
        page: The result as Markdown, and the command that made it.

    Returns:
        The exit code.
    """
    parser = argparse.ArgumentParser(description=(what or "").partition("\n")[0])
    parser.add_argument("run", type=Path, help="folder that `avsec run` wrote")
    parser.add_argument("--markdown", type=Path, help="also write tables into this file")
    parser.add_argument("--json", type=Path, help="write here instead of standard output")

    def made(options: argparse.Namespace) -> R:
        result = measured(RunFolder.open(options.run))
        if options.markdown is not None:
            text = page(result, f"python -m {module} RUN --markdown FILE")
            write_text(options.markdown, text, overwrite=True)
        return result

    return answer(parser.parse_args(arguments), made)
