"""A detector's results as a KITTI folder: a text file for each frame, written as they come."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.label_folders import frame_ids
from avsec_gym.kitti.labels import write_detections
from avsec_gym.perception.weights.weights_file import weights_file_hash
from avsec_gym.progress import Progress
from avsec_gym.registry import make
from avsec_gym.storage.folder_lock import locked_folder
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.portable_names import portable
from avsec_gym.storage.regular_files import is_there
from avsec_gym.storage.text_files import read_text, write_text
from avsec_gym.worker_processes import each_in_processes

if TYPE_CHECKING:
    from avsec_gym.perception.detectors.detector import Detector

RECORD = "detector.json"
"""The file beside the results that states whose they are, and of which data."""

_ANOTHER = "Name another folder: results of two runs in one would be scored as one."


@dataclass(frozen=True)
class WrittenFrames:
    """What became of the frames."""

    written: int
    kept: int
    """Files that an earlier run had written."""
    skipped: dict[str, DataError]
    """What the detector could not see, by the frame's id."""


def write_result_folder(
    kitti: str | Path,
    ids: Sequence[str],
    detector: Any,
    out: str | Path,
    *,
    workers: int = 1,
    on_progress: Progress | None = None,
) -> WrittenFrames:
    """Write what a detector sees as ``000107.txt`` and so on, empty where it finds nothing.

    Files that are there already are kept, so that a run that was stopped goes on.

    Args:
        kitti: A folder in KITTI's object layout.
        ids: The ids of the frames.
        detector: What `avsec_gym.registry.make` takes; no live object with several workers.
        out: The folder: new, empty, or with results of the same detector on the same data.
        workers: The number of processes; each makes a detector of its own.
        on_progress: Function that gets how many frames of how many are done.

    Raises:
        ConfigurationError: There is no such detector, or a live one meets several workers.
        DataError: The folder holds other results, another process is writing there, a worker died,
            or no frame could be used.
    """
    data = KittiObject(kitti)
    if workers > 1 and not isinstance(detector, (str, Mapping)):
        raise ConfigurationError("several workers need the name of a detector, not the object")
    seeing = make("detector", detector) if workers == 1 else None
    with locked_folder(out) as out:
        _claim(out, detector, data)
        there = set(frame_ids(out, ".txt"))
        wanted = [id for id in ids if id not in there]
        kept, skipped = len(ids) - len(wanted), {}
        results = (
            _in_processes(detector, data, out, wanted, workers)
            if seeing is None
            else ((id, _detect(seeing, data, out, id)) for id in wanted)
        )
        with closing(results):
            for done, (id, error) in enumerate(results, start=kept + 1):
                if error is not None:
                    skipped[id] = error
                if on_progress is not None:
                    on_progress(done, len(ids))
    if skipped and len(skipped) == len(ids):
        raise skipped[ids[0]]
    return WrittenFrames(len(wanted) - len(skipped), kept, dict(sorted(skipped.items())))


@dataclass(frozen=True)
class RecordedDetector:
    """The detector whose results a folder holds."""

    detector: Any
    """A name, or JSON with arguments; empty where nothing is recorded."""
    attack: Any
    """Likewise; empty where nothing attacked."""
    weights: str | None
    """SHA-256 of the file of the detector's weights when the results were made; None: unknown."""


def recorded_detector(out: str | Path) -> RecordedDetector:
    """The detector of a result folder, as `avsec detect` has recorded it.

    Args:
        out: The folder.

    Raises:
        DataError: The record is damaged.
    """
    path = Path(out) / RECORD
    record = read_json_object(path, remedy=_ANOTHER) if is_there(path) else {}
    detector, attack = _taken_apart(record.get("detector", ""))
    return RecordedDetector(detector, attack, record.get("weights"))


def _taken_apart(detector: Any) -> tuple[Any, Any]:
    """A detector and the attack on it; an empty string where nothing attacks it."""
    if isinstance(detector, Mapping) and detector.get("name") == "attacked":
        return detector.get("detector", ""), detector.get("attack", "")
    return detector, ""


def _claim(out: Path, detector: Any, data: KittiObject) -> None:
    """State whose results these are.

    Raises:
        DataError: They are another detector's, of other weights, or of other data.
    """
    named = detector if isinstance(detector, (str, Mapping)) else detector.name
    record = {
        "detector": named,
        "weights": weights_file_hash(_taken_apart(named)[0]),
        "data": str(data.folder.resolve()),
    }
    text = json.dumps(portable(record), indent=1, default=str) + "\n"
    path = out / RECORD
    if not is_there(out) or not frame_ids(out, ".txt"):
        write_text(path, text, overwrite=True)
    elif not is_there(path) or read_text(path) != text:
        raise DataError(
            "The results here are of another detector, of other weights, or of other data.",
            path=out,
            remedy=_ANOTHER,
        )


def _detect(detector: Detector, data: KittiObject, out: Path, id: str) -> DataError | None:
    """Write one frame's file; the error, if the frame cannot be used."""
    try:
        found = detector.detect(data.frame(id))
    except DataError as error:
        return error
    write_detections(out / f"{id}.txt", found, overwrite=True)
    return None


def _in_processes(
    detector: Any, data: KittiObject, out: Path, ids: Sequence[str], workers: int
) -> Generator[tuple[str, DataError | None], None, None]:
    if not ids:
        return
    workers = min(workers, len(ids))
    threads = max(1, (os.cpu_count() or 1) // workers)
    detecting = partial(_detecting, detector, data, out, threads)
    with closing(each_in_processes(detecting, ids, workers, threads=threads, folder=out)) as done:
        yield from done


def _detecting(
    detector: Any, data: KittiObject, out: Path, threads: int
) -> Callable[[str], DataError | None]:
    """In a worker: what writes a frame's file."""
    seeing = make("detector", detector)
    if "torch" in sys.modules:
        sys.modules["torch"].set_num_threads(threads)
    return partial(_detect, seeing, data, out)
