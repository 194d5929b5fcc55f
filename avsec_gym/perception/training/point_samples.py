"""Labelled scans as PointRCNN sees them: points in view with their boxes, a small file each."""

from __future__ import annotations

import io
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.kitti.sensor_files import MAX_SCAN_BYTES
from avsec_gym.perception.detectors.pointrcnn.configuration import PointRcnnConfiguration
from avsec_gym.perception.detectors.pointrcnn.points_input import points_in_view
from avsec_gym.perception.nn.points_in_boxes import points_in_boxes
from avsec_gym.perception.training.labelled_frames import (
    DataFrames,
    FramePlace,
    LabelledFrames,
    frame_places,
)
from avsec_gym.perception.training.prepared_once import fingerprint
from avsec_gym.perception.training.scan_samples import ABOVE_GROUND, FEWEST_POINTS, NEEDED
from avsec_gym.progress import Progress
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.npz_files import read_npz

_FORMAT = 1
_STEP = 0.004
"""Metres: stored as whole numbers, a fifth of the sensor's noise."""
_THREADS = 2


@dataclass(frozen=True, eq=False)
class PointSample:
    """A scan with its truth, all in the camera frame.

    Args:
        points: The points in view, shape (M, 3).
        objects: The objects that can be found, rows as `points_in_boxes` takes them, shape (N, 7).
        ignored: The objects that need not be found, as hardly a point is on them, shape (K, 7).
    """

    points: NDArray[np.float32]
    objects: Floats
    ignored: Floats

    def mirrored(self) -> PointSample:
        """Left and right exchanged."""

        def boxes(rows: Floats) -> Floats:
            return np.column_stack([-rows[:, 0], rows[:, 1:6], np.pi - rows[:, 6]])

        sides = np.array([-1, 1, 1], np.float32)
        return PointSample(self.points * sides, boxes(self.objects), boxes(self.ignored))

    def turned(self, angle: float) -> PointSample:
        """Turned about the camera's y axis, as `rotation_y` counts, by an angle in radians."""
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])

        def boxes(rows: Floats) -> Floats:
            return np.column_stack([rows[:, :3] @ turn, rows[:, 3:6], rows[:, 6] + angle])

        points = self.points @ turn.astype(np.float32)
        return PointSample(points, boxes(self.objects), boxes(self.ignored))

    def scaled(self, factor: float) -> PointSample:
        """Everything larger and farther by a factor."""
        sizes = np.array([*[factor] * 6, 1.0])
        points = self.points * np.float32(factor)
        return PointSample(points, self.objects * sizes, self.ignored * sizes)


class PointSamples(LabelledFrames):
    """Scans with their truth; see `prepare_point_samples`."""

    def __init__(self, places: Sequence[FramePlace], files: Sequence[Path]) -> None:
        super().__init__(places)
        self._files = files

    def __getitem__(self, index: int) -> PointSample:
        """A sample as it is."""
        remedy = "Remove the file; it is made anew."
        stored = read_npz(self._files[index], most=MAX_SCAN_BYTES, remedy=remedy)
        points = (stored["points"] * np.float32(_STEP)).astype(np.float32)
        return PointSample(points, stored["objects"], stored["ignored"])


def prepare_point_samples(
    frames: Sequence[DataFrames],
    configuration: PointRcnnConfiguration,
    folder: Path,
    *,
    on_progress: Progress | None = None,
) -> PointSamples:
    """Take the points in view out of scans, and sort their labels, where that is not done yet.

    Args:
        frames: The frames, each with the files of `NEEDED`.
        configuration: The configuration of the network.
        folder: Where the files are kept.
        on_progress: Function that gets frames done and frames in all, of those that are to be done.

    Raises:
        DataError: A file is missing or broken, or there is no frame.
    """
    places = frame_places(frames, folder)
    files = [folder / f"points-{_fingerprint(place, configuration)}.npz" for place in places]
    missing = [place for place in zip(places, files, strict=True) if not place[1].is_file()]

    def prepare(what: tuple[FramePlace, Path]) -> None:
        place, path = what
        sample = point_sample(place.frame(), place.labels(), configuration)
        content = io.BytesIO()
        stored = np.round(sample.points / _STEP).clip(-32768, 32767).astype(np.int16)
        np.savez(content, points=stored, objects=sample.objects, ignored=sample.ignored)
        write_bytes(path, content.getvalue(), overwrite=True)

    with ThreadPoolExecutor(_THREADS) as threads:
        for done, _ in enumerate(threads.map(prepare, missing), start=1):
            if on_progress is not None:
                on_progress(done, len(missing))
    return PointSamples(places, files)


def point_sample(
    frame: SensorFrame, labels: Boxes3D, configuration: PointRcnnConfiguration
) -> PointSample:
    """The sample of a frame.

    Args:
        frame: The frame, with a scan and image 2.
        labels: The labels of this frame.
        configuration: The configuration of the network: what it sees, and looks for.
    """
    points = points_in_view(frame, configuration.view)
    wanted = labels[np.isin(labels.category, (configuration.category, *configuration.alike))]
    boxes = np.column_stack([wanted.location, wanted.dimensions, wanted.rotation_y])
    above = boxes - np.array([0, ABOVE_GROUND, 0, ABOVE_GROUND, 0, 0, 0])
    inside = points_in_boxes(torch.from_numpy(points).double(), torch.from_numpy(above))
    found = inside.sum(1).numpy() >= FEWEST_POINTS
    return PointSample(points, boxes[found], boxes[~found])


def _fingerprint(place: FramePlace, configuration: PointRcnnConfiguration) -> str:
    """Changes with the frame's files, with what is seen of it, and with what is looked for."""
    wanted = (configuration.view, configuration.category, configuration.alike)
    return fingerprint((_FORMAT, wanted), map(place.file, NEEDED))[:24]
