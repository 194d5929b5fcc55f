"""Renders the demo's frames and makes its drives in a process of its own, while this one attacks.

Both are rendered there, one after the other: the textures are drawn once, and the renderer is
compiled once.  The last drive is left to this process, which waits for the frames meanwhile.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path

from avsec_gym.drives.drive_folder import ROWS, has_drives
from avsec_gym.drives.one_drive import Driven
from avsec_gym.errors import AvsecError
from avsec_gym.experiments.demo.contested_frames import contested_frames
from avsec_gym.experiments.demo.drive_on import SETTINGS, drive_on, has_known_scene, last_drive
from avsec_gym.experiments.demo.quick_compilation import quick_compilation
from avsec_gym.progress import Progress
from avsec_gym.storage.regular_files import read_text
from avsec_gym.worker_processes import Worker
from avsec_gym.world.export import Sensors, suite_recipe

_SECONDS_BETWEEN_LOOKS = 1.0


class DrivesAhead:
    """Drives that are being made, or none.

    Args:
        out: Folder of the drives.
        seed: The demo's seed.
        worker: The process that makes them; None: there is none.
    """

    def __init__(self, out: Path, seed: int, worker: Worker | None) -> None:
        self._out, self._seed, self._worker = out, seed, worker

    def drive_beside(self, on_progress: Progress) -> Driven | None:
        """Make the drive that is left to this process, which has to wait for the frames anyway.

        Args:
            on_progress: Function that gets the number of drives that are done and that of all.

        Returns:
            The drive, which nothing has filed yet; None: no process was begun, or it makes all.
        """
        is_left = self._worker is not None and has_known_scene(self._seed)
        if not is_left or self._done() == len(SETTINGS):
            return None
        on_progress(0, len(SETTINGS))
        return last_drive(self._seed)

    def wait_for_frames(self, on_progress: Progress) -> None:
        """Wait until the process has rendered the frames, or can not.

        Args:
            on_progress: Function that gets the number of frames that are there and that of all.
        """
        with suppress(EOFError, AvsecError):
            while self._worker is not None and (seen := self._worker.receive()) is not None:
                on_progress(*seen)

    def is_busy(self) -> bool:
        """Whether a process still drives."""
        worker = self._worker
        return worker is not None and not worker.said_something(0.0) and not worker.has_left()

    def wait_for_drives(self, on_progress: Progress) -> None:
        """Wait until the process has made its drives, or can not.

        Args:
            on_progress: Function that gets the number of drives that are done and that of all.
        """
        worker = self._worker
        while worker is not None and not worker.said_something(_SECONDS_BETWEEN_LOOKS):
            if worker.has_left():
                break
            on_progress(self._done(), len(SETTINGS))

    def _done(self) -> int:
        """How many drives are filed."""
        return read_text(self._out / ROWS).count("\n") if has_drives(self._out) else 0


@contextmanager
def drives_ahead(out: Path, scenes: int, seed: int, processes: int) -> Iterator[DrivesAhead]:
    """Begin the demo's frames and drives beside other work.

    What goes wrong is left to `contested_frames` and `drive_on`: at the end of the context the
    process is ended, whatever it has in hand, and they make what is missing then.

    Args:
        out: Folder of the drives.
        scenes: The number of frames.
        seed: The demo's seed.
        processes: The number of processes that may work; of one alone none is taken for the drives.

    Example:
        >>> with drives_ahead(Path("out/drives"), scenes=3, seed=0, processes=1) as ahead:
        ...     ahead.wait_for_drives(lambda done, total: None)  # Nothing was begun.
    """
    worker = Worker(_render, out, scenes, seed, processes - 1, threads=1) if processes > 1 else None
    try:
        yield DrivesAhead(out, seed, worker)
    finally:
        if worker is not None:
            worker.dismiss(at_once=True)
            worker.join()


def _compile_the_renderer() -> None:
    """Render a frame that is not kept.

    The other process meanwhile compiles the planner, which the choice of scenes needs.
    """
    with tempfile.TemporaryDirectory() as root:
        suite_recipe("street", 1, sensors=Sensors(lidar=False)).make(Path(root), 0)


def _render(connection: Connection, out: Path, scenes: int, seed: int, processes: int) -> None:
    with quick_compilation():
        with suppress(AvsecError):
            _compile_the_renderer()
            contested_frames(scenes, seed, processes, lambda *done: connection.send(done))
        connection.send(None)
        with suppress(AvsecError):
            drive_on(out, seed, but_last=has_known_scene(seed))
        connection.send(None)
