"""What the process of a command is to the system: it ends when asked to, and writes any text."""

from __future__ import annotations

import io
import signal
import sys
from types import FrameType


class Terminated(KeyboardInterrupt):
    """The system, or a user, asks this process to end; everything ends as after Ctrl-C.

    Args:
        number: Of the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def end_when_asked() -> None:
    """From now on, SIGTERM and a closed terminal raise `Terminated` once.

    What the caller of this process has had ignored, as ``nohup`` does, stays ignored.
    """
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)  # Windows has no SIGHUP.
        if number is not None and signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, _end)


def write_any_text() -> None:
    """Characters that the terminal's encoding lacks are written as escapes, not as an error."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.encoding.lower() != "utf-8":
            stream.reconfigure(errors="backslashreplace")


def _end(number: int, _: FrameType | None) -> None:
    signal.signal(number, signal.SIG_IGN)  # Another one must not disturb the leaving.
    raise Terminated(number)
