"""Crops of labelled objects, cut out once, with those of the frames before, and kept on disk."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.perception.motion.classifier import Neighbour, neighbour_of, object_crops
from avsec_gym.perception.motion.network import MotionConfiguration
from avsec_gym.perception.training.prepared_once import fingerprint
from avsec_gym.perception.training.scene_frames import SceneFrame
from avsec_gym.progress import Progress
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.npz_files import read_npz
from avsec_gym.storage.regular_files import MAX_FILE_BYTES

OBSTACLES = ("Car", "Van", "Truck", "Misc")
"""What becomes an obstacle of the planner: the others' motion is never asked for."""
GAPS = 2
"""Neighbours of a sample: the earliest frame that can be used, and the latest."""

_FORMAT = 4
_LOWEST, _MOST_TRUNCATION, _MOST_OCCLUSION = 14.0, 0.7, 2
"""Least height in pixels, most truncation (share) and occlusion (KITTI's level) of a sample."""
_THREADS = 2


@dataclass(frozen=True, eq=False)
class MotionSamples:
    """N objects, each cut out by V boxes: the true one, then such as a detector might give.

    Args:
        now: The crops of the frame itself, with a margin around, shape (N, V, H, W, 3).
        before: The crops at each gap, under both stories, shape (N, V, GAPS, 2, H, W, 3); without
            gaps for single crops.
        known: Whether there is a crop at each gap, shape (N, GAPS).
        moving: Whether each object moves in truth, shape (N,).
        margin: The pixels of it on every side.
    """

    now: NDArray[np.uint8]
    before: NDArray[np.uint8]
    known: NDArray[np.bool_]
    moving: NDArray[np.bool_]
    margin: int

    def __len__(self) -> int:
        return len(self.moving)


def prepare_motion_samples(
    frames: Sequence[SceneFrame],
    configuration: MotionConfiguration,
    folder: Path,
    *,
    variants: int = 3,
    on_progress: Progress | None = None,
) -> MotionSamples:
    """Cut out the objects of frames, unless that is done already.

    Args:
        frames: Frames of the procedural world.
        configuration: The configuration of the network: size of crops, neighbours.
        folder: The folder where the crops are kept.
        variants: How many boxes of each object are cut out.
        on_progress: Function that gets the number of frames done and that of all.

    Raises:
        DataError: A file is broken, or nothing is to be seen in any frame.
    """
    margin = configuration.crop[0] // 16
    path = folder / f"crops-{_fingerprint(frames, configuration, variants)}.npz"
    if not path.is_file():
        parts: list[dict[str, NDArray[Any]]] = []
        for done, part in enumerate(_cut_all(frames, configuration, margin, variants), start=1):
            parts.append(part)
            if on_progress is not None:
                on_progress(done, len(frames))
        columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        if not len(columns["moving"]):
            raise DataError("There is no object to be seen in these frames.", path=folder)
        _save(path, columns)
    stored = read_npz(path, most=MAX_FILE_BYTES, remedy="Remove the file; it is made anew.")
    return MotionSamples(**stored, margin=margin)


def classified_objects(boxes: Boxes3D) -> NDArray[np.bool_]:
    """Which labelled objects are classified: obstacles that can be seen, shape (N,)."""
    assert boxes.box2d is not None, "labels have 2D boxes"
    found = np.isin(boxes.category, OBSTACLES)
    found &= boxes.box2d[:, 3] - boxes.box2d[:, 1] >= _LOWEST
    for values, most in (
        (boxes.truncation, _MOST_TRUNCATION),
        (boxes.occlusion, _MOST_OCCLUSION),
    ):
        if values is not None:
            found &= values <= most
    return np.asarray(found)


def disturbed(boxes: Boxes3D, randomness: np.random.Generator) -> Boxes3D:
    """Boxes as a stereo detector might see them: above all, nearer or farther.

    Args:
        boxes: True ones, with 2D boxes.
        randomness: The generator that draws the errors.
    """
    assert boxes.box2d is not None, "labels have 2D boxes"
    count = len(boxes)
    farther = 1 + 0.03 * randomness.standard_normal((count, 1))
    sides = np.tile(boxes.box2d[:, 2:] - boxes.box2d[:, :2], 2)
    return replace(
        boxes,
        location=boxes.location * farther + 0.05 * randomness.standard_normal((count, 3)),
        dimensions=boxes.dimensions * np.exp(0.05 * randomness.standard_normal((count, 3))),
        rotation_y=boxes.rotation_y + 0.1 * randomness.standard_normal(count),
        box2d=boxes.box2d + 0.04 * sides * randomness.standard_normal((count, 4)),
    )


def _cut_all(
    frames: Sequence[SceneFrame],
    configuration: MotionConfiguration,
    margin: int,
    variants: int,
) -> Iterator[dict[str, NDArray[Any]]]:
    def cut(index: int) -> dict[str, NDArray[Any]]:
        return _cut(frames[index], configuration, margin, variants, index)

    with ThreadPoolExecutor(_THREADS) as threads:
        yield from threads.map(cut, range(len(frames)))


def _cut(
    labelled: SceneFrame,
    configuration: MotionConfiguration,
    margin: int,
    variants: int,
    seed: int,
) -> dict[str, NDArray[Any]]:
    everything, frame = labelled.boxes(), labelled.frame()
    boxes = everything[classified_objects(everything)]
    # From the earliest frame before, and from the latest alone: two gaps in time.
    gaps: list[Neighbour | None] = []
    if configuration.neighbour:
        latest = replace(frame, previous=frame.previous[:1])
        gaps = [neighbour_of(seen, everything) for seen in (frame, latest) if len(boxes)]
    # Every variant with a margin, so that training can shift the crops.
    randomness = np.random.default_rng([seed, len(boxes)])
    size = [side + 2 * margin for side in configuration.crop]
    now = np.zeros((len(boxes), variants, *size, 3), np.uint8)
    before = np.zeros((len(boxes), variants, GAPS * configuration.neighbour, 2, *size, 3), np.uint8)
    known = np.zeros((len(boxes), GAPS), bool)
    for variant in range(variants if len(boxes) else 0):
        seen = boxes if variant == 0 else disturbed(boxes, randomness)
        now[:, variant] = object_crops(seen, frame, None, configuration.crop, margin=margin).now
        for gap, neighbour in enumerate(gaps):
            cut = object_crops(seen, frame, neighbour, configuration.crop, margin=margin)
            if cut.before is not None:
                before[:, variant, gap], known[:, gap] = cut.before, True
    return {"now": now, "before": before, "known": known, "moving": np.asarray(boxes.moving)}


def _save(path: Path, columns: dict[str, NDArray[Any]]) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, **columns)  # type: ignore[arg-type]
    write_bytes(path, buffer.getvalue(), overwrite=True)


def _fingerprint(
    frames: Sequence[SceneFrame], configuration: MotionConfiguration, variants: int
) -> str:
    """Changes with the frames, their labels and the crops; not with the network."""
    facts = (_FORMAT, configuration.crop, configuration.neighbour, variants)
    files = (file for frame in frames for file in (frame.left, frame.labels, frame.facts))
    return fingerprint(facts, files)[:16]
