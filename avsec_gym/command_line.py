"""The command of this process as its user would type it again."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

_OURS = ("avsec", "__main__.py")


def command_line() -> str:
    """It, quoted for a shell; ``avsec``, wherever that is installed, or ``python -m avsec_gym``."""
    program, *arguments = sys.argv
    return shlex.join(["avsec" if Path(program).name in _OURS else program, *arguments])
