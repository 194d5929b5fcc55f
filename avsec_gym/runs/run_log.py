"""``run.log``, which several processes write."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from avsec_gym.errors import DataError

JOURNAL = logging.getLogger("avsec_gym.journal")
"""What goes into the log only."""


class LogFile(logging.FileHandler):
    """Appends to a log, as long as there is room.

    Rows are what counts: a disk that is full ends the run where they are stored, not here.

    Args:
        path: The log.

    Raises:
        DataError: It cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        if path.is_fifo():
            raise DataError("This is a pipe.", path=path, remedy="Remove it; a log is a file.")
        try:
            super().__init__(path, encoding="utf-8", errors="backslashreplace")
        except OSError as error:
            raise DataError(
                f"The log cannot be written ({error.strerror}).",
                path=path,
                remedy="Check the permissions of the folder and its files.",
            ) from error
        self.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))

    def handleError(self, record: logging.LogRecord) -> None:
        """Say nothing: logging would print a traceback for each line."""

    def close(self) -> None:
        """Write what has room."""
        with suppress(OSError):
            super().close()


@contextmanager
def log_into(path: Path) -> Iterator[None]:
    """The journal goes into the run's log only; warnings of the package also there."""
    handler = LogFile(path)
    package = logging.getLogger("avsec_gym")
    JOURNAL.propagate = False
    JOURNAL.setLevel(logging.INFO)
    for logger in (package, JOURNAL):
        logger.addHandler(handler)
    try:
        yield
    finally:
        for logger in (package, JOURNAL):
            logger.removeHandler(handler)
        handler.close()
