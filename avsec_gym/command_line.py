"""The command of this process as its user would type it again."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

_OURS = ("avsec", "avsec.exe", "avsec_gym/__main__.py")


def command_line() -> str:
    """It, quoted for a shell; ``avsec``, wherever that is installed, or ``python -m avsec_gym``."""
    program, *arguments = sys.argv
    path = Path(program)
    ours = path.name in _OURS or "/".join(path.parts[-2:]) in _OURS
    return shlex.join(["avsec" if ours else program, *arguments])
