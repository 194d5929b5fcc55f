"""What commands of experiments do with a result: JSON to standard output or into a file."""

from __future__ import annotations

import argparse
import json
import logging
import sys
from collections.abc import Callable

from avsec_gym.errors import AvsecError
from avsec_gym.experiments.json_rows import as_json

_LOG = logging.getLogger(__name__)


def answer(options: argparse.Namespace, run: Callable[[argparse.Namespace], object]) -> int:
    """Run, and write the result, rows or JSON, into the file of the option ``json``.

    Args:
        options: Options of the command line; `json` is a path or None for standard output.
        run: The function from the options to the result.

    Returns:
        The exit code: 1 where data or options were bad, which is reported.
    """

    def work() -> None:
        text = json.dumps(as_json(run(options)), indent=1, allow_nan=False) + "\n"
        if options.json is None:
            sys.stdout.write(text)
        else:
            options.json.parent.mkdir(parents=True, exist_ok=True)
            options.json.write_text(text)

    return exit_code(work)


def exit_code(work: Callable[[], None]) -> int:
    """Do the work; 1 where data or options were bad, which is reported."""
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    try:
        work()
    except AvsecError as error:
        _LOG.error("%s", error)
        return 1
    return 0
