"""The command that shows a kept result as a page: ``python -m MODULE RESULT --out PAGE``."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from avsec_gym.errors import DataError
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.storage.json_files import read_json
from avsec_gym.storage.text_files import write_text
from studies.answer import exit_code

R = TypeVar("R")


def page_of_result(
    arguments: Sequence[str] | None,
    kind: type[R],
    page: Callable[[R], str],
    *,
    maker: str,
    what: str | None,
    remedy: str,
) -> int:
    """Read a result, and write its page.

    Args:
        arguments: The words of the command line; None: those of the process.
        kind: The dataclass of the result.
        page: Function from the result to Markdown.
        maker: Name of the study's part that makes the result.
        what: Docstring of the module, whose first line is the help.
        remedy: How the result is made.

    Returns:
        The exit code: 1 where the result is missing or broken, which is reported.
    """
    parser = argparse.ArgumentParser(description=(what or "").partition("\n")[0])
    parser.add_argument("result", type=Path, help=f"of {maker}, as JSON")
    parser.add_argument("--out", type=Path, required=True, help="the page")
    options = parser.parse_args(arguments)

    def work() -> None:
        try:
            text = page(row_of(kind, read_json(options.result, remedy=remedy)))
        except (ValueError, KeyError, TypeError) as error:
            raise DataError(
                f"This is no result of {maker}.", path=options.result, remedy=remedy
            ) from error
        write_text(options.out, text, overwrite=True)

    return exit_code(work)
