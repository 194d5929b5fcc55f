"""The process that reads damaged files: a folder a line in, an outcome a line out."""

from __future__ import annotations

import json
import logging
import os
import resource
import sys
import traceback
import warnings
from pathlib import Path
from typing import Any

from kinds import KINDS, Kind

MOST_MEMORY = 3 * 2**30
"""Bytes beyond what the process takes by itself: who asks for more has believed a file's header."""


def main() -> None:
    """Read until the input ends."""
    kind = KINDS[sys.argv[1]]
    warnings.simplefilter("ignore")
    logging.disable()
    # Libraries may print: the answers have a channel of their own.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    limited = False
    for line in sys.stdin:
        outcome = read(kind, Path(line.rstrip("\n")))
        answers.write(json.dumps(outcome) + "\n")
        answers.flush()
        if not limited:  # The first one is sound, and loads whatever is loaded once.
            limited = True
            pages = int(Path("/proc/self/statm").read_text().split()[0])
            most = pages * resource.getpagesize() + MOST_MEMORY
            resource.setrlimit(resource.RLIMIT_AS, (most, most))


def read(kind: Kind, folder: Path) -> dict[str, Any]:
    """What comes of a folder with a damaged file."""
    from avsec_gym.errors import AvsecError

    try:
        value = kind.read(folder)
        problem = kind.impossible(value)
    except AvsecError as error:
        message = str(error)
        named = folder.name in message or Path(kind.file).stem in message
        return {"outcome": "refused" if named else "nameless", "detail": message[-300:]}
    except MemoryError:
        return {"outcome": "memory", "detail": _where()}
    except BaseException as error:
        return {
            "outcome": "traceback",
            "detail": f"{type(error).__name__}: {error} at {_where()}"[:400],
        }
    if problem is not None:
        return {"outcome": "impossible", "detail": problem}
    return {"outcome": "read", "detail": ""}


def _where() -> str:
    frames = traceback.extract_tb(sys.exc_info()[2])
    ours = [frame for frame in frames if "avsec_gym" in frame.filename] or frames
    return f"{Path(ours[-1].filename).name}:{ours[-1].lineno}"


if __name__ == "__main__":
    main()
