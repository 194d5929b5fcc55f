"""What the process of a command is to the system: it ends when asked to, and writes any text.

A stream that the caller has closed is `os.devnull` here: what goes there is lost, as was asked for.
"""

from __future__ import annotations

import codecs
import io
import os
import select
import signal
import sys
from contextlib import suppress
from types import FrameType

_PLAIN = "avsec_gym.plain"
"""Name of the error handler of standard output and standard error."""
_DASHES = "–—−"


class Terminated(KeyboardInterrupt):
    """The system, or a user, asks this process to end; everything ends as after Ctrl-C.

    Args:
        number: The number of the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def end_when_asked() -> None:
    """Make SIGTERM and a closed terminal raise `Terminated` once, from now on.

    What the caller of this process has had ignored, as ``nohup`` does, stays ignored.
    """
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)  # Windows has no SIGHUP.
        if number is not None and signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, _end)


def stand_in_for_closed_streams() -> None:
    """Open `os.devnull` for each standard stream that is closed, as by ``>&-`` in a shell.

    Else `sys.stdout` is None, and the next file that is opened takes the number to which libraries
    print.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            handle = os.open(os.devnull, os.O_RDWR)
            if handle != number:
                os.dup2(handle, number)
                os.close(handle)
            stream = os.fdopen(number, "r" if name == "stdin" else "w", encoding="utf-8")
            setattr(sys, name, stream)


def settle_output() -> None:
    """Write what the output streams still hold, or give it up where that cannot be done.

    Else Python tries again when it leaves, and reports it in words of its own.
    """
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            handle = os.open(os.devnull, os.O_WRONLY)
            os.dup2(handle, stream.fileno())
            os.close(handle)


def output_is_cut_off() -> bool:
    """Whether the reader of standard output, or of standard error, has left, as `head` does.

    A `BrokenPipeError` alone is no sign of it: other pipes break, too, as that of a worker does
    which has died.
    """
    if not hasattr(select, "poll"):  # Windows
        return True
    streams = select.poll()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError):  # What stands in for a stream, as in a notebook, has no number.
            streams.register(stream.fileno(), 0)
    gone = select.POLLERR | select.POLLHUP
    return any(events & gone for _, events in streams.poll(0))


def write_any_text() -> None:
    """Characters that the terminal's encoding lacks are no error.

    Dashes of intervals and signs are written as hyphens, all others as escapes.  UTF-8 lacks what
    Python makes of the bytes of a file's name that are no UTF-8.
    """
    codecs.register_error(_PLAIN, _plainly)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_PLAIN)


def _plainly(error: UnicodeError) -> tuple[str | bytes, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    if error.object[error.start] in _DASHES:
        return "-", error.start + 1
    error.end = error.start + 1
    return codecs.backslashreplace_errors(error)


def _end(number: int, _: FrameType | None) -> None:
    signal.signal(number, signal.SIG_IGN)  # Another one must not disturb the leaving.
    raise Terminated(number)
