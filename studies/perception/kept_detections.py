"""Labelled frames, and what detectors find in them, kept from one run to the next; the time."""

from __future__ import annotations

import argparse
import hashlib
import statistics
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import avsec_gym.perception
from avsec_gym.boxes import Boxes3D
from avsec_gym.console import progress
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.detections import DetectionFolder
from avsec_gym.kitti.labels import DONT_CARE
from avsec_gym.metrics.average_precision_frames import COUNTED, LEVELS, label_status, pooled
from avsec_gym.perception.detectors import make_detector
from avsec_gym.perception.result_folder import write_result_folder
from avsec_gym.perception.weights.store import card_path
from avsec_gym.storage.regular_files import MAX_FILE_BYTES, is_file, read_bytes
from avsec_gym.world.export import MANIFEST, read_manifest
from studies.perception.detection_errors import CATEGORY


@dataclass(frozen=True)
class CarsToFind:
    """Labelled cars of frames: all, and those to be found at each level of difficulty."""

    all: int
    easy: int
    moderate: int
    hard: int


@dataclass(frozen=True)
class LabelledData:
    """Which frames were judged on; None where they are of no suite of the procedural world."""

    suite: str | None
    seed: int | None
    assets: str | None
    fingerprint: str | None
    """Fingerprint of the sources of the world."""
    frames: int
    objects: int
    cars: CarsToFind


@dataclass(frozen=True)
class FrameTime:
    """The time from decoded sensor data to boxes."""

    median: float
    """The median time, seconds."""
    frames: int
    threads: int


def add_options(parser: argparse.ArgumentParser) -> None:
    """What commands ask for that measure detectors on labelled frames."""
    parser.add_argument("--kitti", type=Path, required=True, help="frames in KITTI's layout")
    parser.add_argument(
        "--out", type=Path, default=Path("runs/detector_precision"), help="for what was detected"
    )
    parser.add_argument(
        "--any-assets",
        action="store_true",
        help="also frames of the procedural world that are not of judging assets",
    )
    parser.add_argument("--limit", type=int, help="only the first frames")
    parser.add_argument("--workers", type=int, default=1, help="processes that detect")
    parser.add_argument("--resamples", type=int, default=1000, help="of frames, for intervals")
    parser.add_argument("--seed", type=int, default=0, help="of these")
    parser.add_argument("--timed", type=int, default=10, help="frames whose time is taken")
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")


def labelled_frames(
    options: argparse.Namespace, needed: Sequence[str], make: str
) -> tuple[KittiObject, list[str], list[Boxes3D]]:
    """The frames that are asked for, and their labels, DontCare regions included.

    Args:
        options: The options of the command, see `add_options`.
        needed: Folders in which a frame has a file.
        make: Command that makes such frames.

    Raises:
        ConfigurationError: An option makes no sense.
        DataError: There is no such frame, or a file is broken.
    """
    if options.resamples < 0 or min(options.timed, options.limit or 1) < 1:
        raise ConfigurationError("--resamples is 0 or more, --timed and --limit are 1 or more")
    data = KittiObject(options.kitti)
    ids = data.ids(having=tuple(needed))[: options.limit]
    if not ids:
        raise DataError(
            f"No frame has a file in each of {', '.join(needed)}.",
            path=options.kitti,
            remedy=f"`{make}` makes some.",
        )
    return data, ids, [data.labels(id, keep_dont_care=True) for id in ids]


def check_judging_assets(data: LabelledData, options: argparse.Namespace) -> None:
    """Check that frames of the procedural world show assets that are kept for judging.

    Args:
        data: The frames; of no suite are those of other origin, which have no such assets.
        options: The options of the command, see `add_options`.

    Raises:
        ConfigurationError: They show others, and ``--any-assets`` is not given.
    """
    if data.suite is None or data.assets == "judge" or options.any_assets:
        return
    raise ConfigurationError(
        f"the frames of --kitti are of the assets {data.assets or 'all'!r}, which networks learn"
        " from: give frames of `avsec world make --assets judge`, or --any-assets if that is meant"
    )


def detected(
    what: Mapping[str, Any],
    weights: Path | None,
    data: KittiObject,
    ids: Sequence[str],
    out: Path,
    workers: int = 1,
) -> list[Boxes3D]:
    """What a detector finds in frames; kept in a folder of `out`, from which a run goes on.

    The folder's name changes with the code of perception, the weights and the data, so that no
    older results are ever taken for these.

    Args:
        what: What `make_detector` takes.
        weights: File of the detector's weights; None for a detector without.
        data: Where the frames are.
        ids: The ids of the frames.
        out: The folder of the results.
        workers: Processes that detect.

    Raises:
        DataError: A frame cannot be used.
    """
    name = dict(what).get("detector", what)["name"]
    folder = out / f"{name}-{_state(weights, data)}"
    with progress(f"detecting, {name}") as shown:
        outcome = write_result_folder(
            data.root, ids, what, folder, workers=workers, on_progress=shown
        )
    if outcome.skipped:
        raise next(iter(outcome.skipped.values()))
    boxes, _ = DetectionFolder(folder).read(ids, image_only=True)
    return [boxes[id] for id in ids]


def described(data: KittiObject, truth: Sequence[Boxes3D]) -> LabelledData:
    """Which frames these are, and how many cars there are to be found.

    Args:
        data: Where they are.
        truth: The labels of the frames, DontCare regions included.
    """
    manifest = read_manifest(data.root) or {}
    settings = manifest.get("settings", {})
    labels = pooled(truth, "labels")
    categories = np.concatenate([boxes.category for boxes in truth])
    wanted = [
        int((label_status(labels, CATEGORY, level) == COUNTED).sum())
        for level in range(len(LEVELS))
    ]
    return LabelledData(
        suite=settings.get("suite"),
        seed=settings.get("seed"),
        assets=settings.get("assets"),
        fingerprint=manifest.get("fingerprint"),
        frames=len(truth),
        objects=int((categories != DONT_CARE).sum()),
        cars=CarsToFind(int((categories == CATEGORY).sum()), *wanted),
    )


def seconds_a_frame(what: Mapping[str, Any], data: KittiObject, ids: Sequence[str]) -> FrameTime:
    """The median time from decoded sensor data to boxes; the first frame is seen twice."""
    import torch

    detector = make_detector(what)
    taken = []
    for id in (ids[0], *ids):
        frame = data.frame(id)
        for camera in frame.images:
            frame.image(camera)
        if frame.has_points:
            _ = frame.points
        begun = time.perf_counter()
        detector.detect(frame)
        taken.append(time.perf_counter() - begun)
    return FrameTime(round(statistics.median(taken[1:]), 4), len(ids), torch.get_num_threads())


def _state(weights: Path | None, data: KittiObject) -> str:
    """Changes with code, weights and data."""
    digest = hashlib.sha256(str(data.folder.resolve()).encode())
    files = sorted(Path(avsec_gym.perception.__path__[0]).rglob("*.py"))
    own = () if weights is None else (weights, card_path(weights))
    for file in (*files, *own, data.root / MANIFEST):
        if is_file(file):
            content = read_bytes(file, most=MAX_FILE_BYTES)
            digest.update(hashlib.sha256(content).digest())
    return digest.hexdigest()[:12]
