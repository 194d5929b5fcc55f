"""A detector's results as a KITTI folder: a text file for each frame, written as they come."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.label_folders import frame_ids
from avsec_gym.kitti.labels import write_detections
from avsec_gym.kitti.text_files import read_text, write_text
from avsec_gym.registry import make

if TYPE_CHECKING:
    from avsec_gym.perception.detectors.detector import Detector

RECORD = "detector.json"
"""Beside the results: whose they are, and of which data."""

_ANOTHER = "Name another folder: results of two runs in one would be scored as one."


@dataclass(frozen=True)
class Outcome:
    """What became of the frames."""

    written: int
    kept: int
    """That an earlier run had written."""
    skipped: dict[str, DataError]
    """What the detector could not see, by the frame's id."""


def write_result_folder(
    kitti: str | Path,
    ids: Sequence[str],
    detector: Any,
    out: str | Path,
    *,
    workers: int = 1,
    on_progress: Callable[[int, int], None] | None = None,
) -> Outcome:
    """Write what a detector sees as ``000107.txt`` and so on, empty where it finds nothing.

    Files that are there already are kept, so that a run that was stopped goes on.

    Args:
        kitti: A folder in KITTI's object layout.
        ids: Frames.
        detector: What `avsec_gym.registry.make` takes; no live object with several workers.
        out: The folder: new, empty, or with results of the same detector on the same data.
        workers: Processes; each makes a detector of its own.
        on_progress: Takes how many frames of how many are done.

    Raises:
        ConfigurationError: There is no such detector, or a live one meets several workers.
        DataError: The folder holds other results, a worker died, or no frame could be used.
    """
    out, data = Path(out), KittiObject(kitti)
    if workers > 1 and not isinstance(detector, (str, Mapping)):
        raise ConfigurationError("several workers need the name of a detector, not the object")
    seeing = make("detector", detector) if workers == 1 else None
    _claim(out, detector, data)
    there = set(frame_ids(out, ".txt"))
    wanted = [id for id in ids if id not in there]
    kept, skipped = len(ids) - len(wanted), {}
    results = (
        _in_processes(detector, data, out, wanted, workers)
        if seeing is None
        else ((id, _detect(seeing, data, out, id)) for id in wanted)
    )
    for done, (id, error) in enumerate(results, start=kept + 1):
        if error is not None:
            skipped[id] = error
        if on_progress is not None:
            on_progress(done, len(ids))
    if skipped and len(skipped) == len(ids):
        raise next(iter(skipped.values()))
    return Outcome(len(wanted) - len(skipped), kept, skipped)


def _claim(out: Path, detector: Any, data: KittiObject) -> None:
    """Say whose results these are.

    Raises:
        DataError: They are somebody else's.
    """
    named = isinstance(detector, (str, Mapping))
    record = {
        "detector": detector if named else detector.name,
        "data": str(data.folder.resolve()),
    }
    text = json.dumps(record, indent=1, default=str) + "\n"
    path = out / RECORD
    if not out.exists() or not frame_ids(out, ".txt"):
        write_text(path, text, overwrite=True)
    elif not path.exists() or read_text(path) != text:
        raise DataError(
            "The results here are of another detector or other data.", path=out, remedy=_ANOTHER
        )


def _detect(detector: Detector, data: KittiObject, out: Path, id: str) -> DataError | None:
    """Write one frame's file; the error, if the frame cannot be used."""
    try:
        found = detector.detect(data.frame(id))
    except DataError as error:
        return error
    # Whole or not at all; two runs at once write the same.
    write_detections(out / f"{id}.txt", found, overwrite=True)
    return None


_WORKER: dict[str, Any] = {}
"""What a worker process keeps between frames."""


def _in_processes(
    detector: Any, data: KittiObject, out: Path, ids: Sequence[str], workers: int
) -> Iterator[tuple[str, DataError | None]]:
    if not ids:
        return
    workers = min(workers, len(ids))
    threads = max(1, (os.cpu_count() or 1) // workers)
    pool = ProcessPoolExecutor(
        workers, get_context("spawn"), _begin, (detector, data, out, threads, os.getpid())
    )
    try:
        yield from zip(ids, pool.map(_detect_there, ids), strict=True)
    except BrokenProcessPool as error:
        raise DataError(
            "A worker process ended before its work.",
            path=out,
            remedy="Was it killed, or is the memory full? With fewer --workers it takes less; run"
            " the command again to go on.",
        ) from error
    finally:
        pool.shutdown(cancel_futures=True)


def _begin(detector: Any, data: KittiObject, out: Path, threads: int, parent: int) -> None:
    """A worker leaves Ctrl-C to its parent, and ends when the parent is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    _WORKER.update(what=detector, data=data, out=out, threads=threads)


def _detect_there(id: str) -> DataError | None:
    # Made at the first frame, not while the process begins: an error then comes back as it is.
    if "detector" not in _WORKER:
        _WORKER["detector"] = make("detector", _WORKER["what"])
        if "torch" in sys.modules:
            sys.modules["torch"].set_num_threads(_WORKER["threads"])
    return _detect(_WORKER["detector"], _WORKER["data"], _WORKER["out"], id)
