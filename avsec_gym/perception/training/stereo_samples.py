"""Labelled stereo pairs, reduced once to the size that a network sees, and kept on disk as arrays.

An epoch then reads memory maps instead of decoding PNGs, which would cost more than a small
network's step.
"""

from __future__ import annotations

import json
import os
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.labels import DONT_CARE
from avsec_gym.kitti.map_files import read_disparity
from avsec_gym.perception.depth.lidar import scan_disparity
from avsec_gym.perception.stereo_batch import batch_of_frames
from avsec_gym.perception.training.disparity_maps import reduced_disparity, seen_from_right
from avsec_gym.perception.training.labelled_frames import (
    DataFrames,
    FramePlace,
    LabelledFrames,
    frame_places,
)
from avsec_gym.perception.training.prepared_once import fingerprint, whole_folder
from avsec_gym.perception.training.sample import Map, StereoSample
from avsec_gym.progress import Progress
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.npy_rows import NpyRows
from avsec_gym.storage.npz_files import map_npy
from avsec_gym.storage.text_files import write_text
from avsec_gym.worker_processes import AVAILABLE, each_in_processes

_FORMAT = 1
_ARRAYS: dict[str, tuple[tuple[int, ...], Any]] = {
    "left": ((3,), np.uint8),
    "right": ((3,), np.uint8),
    "left_disparity": ((), np.uint16),
    "right_disparity": ((), np.uint16),
}
_STORED_STEPS = 256.0
"""Steps of a disparity's pixel, as in KITTI's files."""
_AGAIN = "Remove the folder; it is made anew."
_FACTS = "samples.json"
_PROCESSORS = os.cpu_count() or 1
_PROCESSES_PAY, _FRAMES_PAY = 6, 200
"""Processors, and frames, from which on processes are quicker than threads, which wait for one
another; processes take seconds to begin."""
_MOST_PROCESSES = 16
"""Each takes half a gigabyte."""
_Reduced = tuple[dict[str, NDArray[Any]], tuple[int, int], Floats]
"""Arrays by name, the camera's own height and width, the projections."""


class StereoSamples(LabelledFrames):
    """Reduced pairs, with labels and disparities; see `prepare_samples`."""

    def __init__(self, folder: Path, places: Sequence[FramePlace]) -> None:
        super().__init__(places)
        self._folder = folder
        facts = read_json_object(folder / _FACTS, remedy=_AGAIN)
        self.sizes: list[tuple[int, int]] = [(int(h), int(w)) for h, w in facts["sizes"]]
        """Heights and widths of the cameras' own images."""
        self._projections = np.array(facts["projections"], np.float64).reshape(-1, 2, 3, 4)
        self._arrays = {name: map_npy(folder / f"{name}.npy", remedy=_AGAIN) for name in _ARRAYS}

    def __reduce__(self) -> tuple[type[StereoSamples], tuple[Path, Sequence[FramePlace]]]:
        """Sent to a process, they are opened again there."""
        return StereoSamples, (self._folder, self._places)

    def __getitem__(self, index: int) -> StereoSample:
        """A sample as it is, images uint8, objects without regions not to care about."""
        left, right = (np.array(self._arrays[name][index]) for name in ("left", "right"))
        height, width = left.shape[:2]
        labels = self.labels[index]
        truth = labels[labels.category != DONT_CARE]
        camera_height, camera_width = self.sizes[index]
        return StereoSample(
            left,
            right,
            self._projections[index, 0],
            self._projections[index, 1],
            self._disparity("left_disparity", index),
            self._disparity("right_disparity", index),
            _scaled(truth, width / camera_width, height / camera_height),
        )

    def groups(self, count: int) -> Iterator[range]:
        """All indices, so many at a time."""
        for start in range(0, len(self), count):
            yield range(start, min(start + count, len(self)))

    def _disparity(self, name: str, index: int) -> Map:
        return self._arrays[name][index].astype(np.float32) / np.float32(_STORED_STEPS)


def prepare_samples(
    frames: Sequence[DataFrames],
    size: tuple[int, int] | None,
    folder: Path,
    *,
    on_progress: Progress | None = None,
) -> StereoSamples:
    """Reduce frames to a size, unless that is done already.

    Args:
        frames: The frames, each with images 2 and 3, calibration and labels; disparities come from
            ``disparity_2``, else from the scan, else they are unknown.
        size: Height and width; that of the first frame's camera if None.
        folder: Where the arrays are kept, for these frames and this size.
        on_progress: Function that gets frames done and frames in all.

    Raises:
        DataError: A file is missing or broken, or there is no frame.
    """
    places = frame_places(frames, folder)
    if size is None:
        height, width = places[0].frame().image(2).shape[:2]
        size = height, width
    # Labels are read anew each time.
    images = fingerprint(_FORMAT, (place.file("image_2") for place in places))[:16]
    there = folder / f"{images}-{size[0]}x{size[1]}"
    if not (there / _FACTS).is_file():
        with whole_folder(there) as partial:
            _write(places, size, partial, on_progress)
    return StereoSamples(there, places)


def _write(
    places: Sequence[FramePlace],
    size: tuple[int, int],
    folder: Path,
    on_progress: Progress | None,
) -> None:
    sizes: list[tuple[int, int]] = [(0, 0)] * len(places)
    projections: list[list[Any]] = [[]] * len(places)
    with ExitStack() as stack:
        arrays = {
            name: stack.enter_context(
                NpyRows(folder / f"{name}.npy", kind, (len(places), *size, *tail))
            )
            for name, (tail, kind) in _ARRAYS.items()
        }
        reduced = stack.enter_context(closing(_all_reduced(places, size, folder)))
        for number, (index, (values, camera_size, matrices)) in enumerate(reduced):
            for name, value in values.items():
                arrays[name][index] = value
            sizes[index], projections[index] = camera_size, matrices.tolist()
            if on_progress is not None:
                on_progress(number + 1, len(places))
    write_text(folder / _FACTS, json.dumps({"sizes": sizes, "projections": projections}))


def _all_reduced(
    places: Sequence[FramePlace], size: tuple[int, int], folder: Path
) -> Generator[tuple[int, _Reduced]]:
    """Each frame's number and what is kept of it, in any order."""
    numbers, make = range(len(places)), partial(partial, _reduced, places, size)
    if AVAILABLE and _PROCESSORS >= _PROCESSES_PAY and len(places) >= _FRAMES_PAY:
        workers = min(_PROCESSORS, _MOST_PROCESSES)
        yield from each_in_processes(make, numbers, workers, threads=1, folder=folder)
        return
    with ThreadPoolExecutor(max(2, _PROCESSORS)) as threads:
        yield from enumerate(threads.map(make(), numbers))


def _reduced(places: Sequence[FramePlace], size: tuple[int, int], index: int) -> _Reduced:
    place = places[index]
    frame = place.frame()
    batch = batch_of_frames([frame])
    small = batch.resized(*size)
    disparity = _true_disparity(place.data, frame, batch.size)
    maps = {"left_disparity": disparity, "right_disparity": seen_from_right(disparity)}
    values: dict[str, NDArray[Any]] = {
        name: np.round(reduced_disparity(map, *size) * _STORED_STEPS)
        .clip(0, 65535)
        .astype(np.uint16)
        for name, map in maps.items()
    }
    for name, image in (("left", small.left), ("right", small.right)):
        values[name] = image[0].permute(1, 2, 0).round().clamp(0, 255).byte().numpy()
    matrices = np.stack([small.left_projection[0].numpy(), small.right_projection[0].numpy()])
    return values, batch.size, matrices


def _true_disparity(data: KittiObject, frame: SensorFrame, shape: tuple[int, int]) -> Map:
    path = data.folder / "disparity_2" / f"{frame.id}.png"
    if path.is_file():
        found = read_disparity(path)
        if found.shape != shape:
            raise DataError(
                f"The disparity map has shape {found.shape}, the image {shape}.",
                path=path,
                remedy="Make the data set again.",
            )
    elif frame.has_points:
        found = scan_disparity(frame.points, frame.calibration, shape, (2, 3))
    else:
        return np.zeros(shape, np.float32)
    return np.nan_to_num(found, nan=0.0)


def _scaled(boxes: Boxes3D, scale_u: float, scale_v: float) -> Boxes3D:
    """2D boxes in pixels of the resized image, by the rule of `StereoBatch.resized`."""
    assert boxes.box2d is not None, "label files have 2D boxes"
    scale = np.array([scale_u, scale_v, scale_u, scale_v])
    return replace(boxes, box2d=(boxes.box2d + 0.5) * scale - 0.5)
