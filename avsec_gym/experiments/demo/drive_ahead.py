"""Makes the demo's drives in a process of its own, while this one renders frames and attacks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path

from avsec_gym.drives.drive_folder import ROWS, has_drives
from avsec_gym.errors import AvsecError
from avsec_gym.experiments.demo.drive_on import SETTINGS, drive_on
from avsec_gym.progress import Progress
from avsec_gym.storage.regular_files import read_text
from avsec_gym.worker_processes import Worker

_SECONDS_BETWEEN_LOOKS = 1.0


class DrivesAhead:
    """Drives that are being made, or none.

    Args:
        out: Folder of the drives.
        worker: The process that makes them; None: there is none.
    """

    def __init__(self, out: Path, worker: Worker | None) -> None:
        self._out, self._worker = out, worker

    def is_busy(self) -> bool:
        """Whether a process still drives."""
        worker = self._worker
        return worker is not None and not worker.said_something(0.0) and not worker.has_left()

    def wait(self, on_progress: Progress) -> None:
        """Wait until the process has made all that it can.

        Args:
            on_progress: Function that gets the number of drives that are done and that of all.
        """
        while self._worker is not None and not self._worker.said_something(_SECONDS_BETWEEN_LOOKS):
            if self._worker.has_left():
                return
            done = read_text(self._out / ROWS).count("\n") if has_drives(self._out) else 0
            on_progress(done, len(SETTINGS))


@contextmanager
def drives_ahead(out: Path, seed: int, processes: int) -> Iterator[DrivesAhead]:
    """Begin the demo's drives beside other work; what goes wrong is left to `drive_on`.

    At the end of the context the process is ended, whatever it has in hand: `drive_on` makes the
    drives that are missing then.

    Args:
        out: Folder of the drives.
        seed: The demo's seed.
        processes: The number of processes that may work; of one alone none is taken for the drives.

    Example:
        >>> with drives_ahead(Path("out/drives"), seed=0, processes=1) as ahead:
        ...     ahead.wait(lambda done, total: None)  # Nothing was begun.
    """
    worker = Worker(_drive, out, seed, threads=1) if processes > 1 else None
    try:
        yield DrivesAhead(out, worker)
    finally:
        if worker is not None:
            worker.dismiss(at_once=True)
            worker.join()


def _drive(connection: Connection, out: Path, seed: int) -> None:
    with suppress(AvsecError):
        drive_on(out, seed)
    connection.send(None)
