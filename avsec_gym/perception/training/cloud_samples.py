"""Labelled LiDAR scans, cropped once to what a network can see of them, and kept as one array.

An epoch then reads a memory map of less than half the files' size, their labels sorted.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Points, SensorFrame
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.perception.detectors.pixor.configuration import BirdEyeRegion
from avsec_gym.perception.detectors.pixor.targets import owners
from avsec_gym.perception.detectors.pixor.upright_boxes import seen_from_above
from avsec_gym.perception.training.labelled_frames import (
    DataFrames,
    FramePlace,
    LabelledFrames,
    frame_places,
)
from avsec_gym.perception.training.prepared_once import fingerprint, whole_folder
from avsec_gym.perception.training.scan_samples import ABOVE_GROUND, FEWEST_POINTS, NEEDED
from avsec_gym.progress import Progress
from avsec_gym.storage.json_files import read_json
from avsec_gym.storage.npy_rows import NewFile, npy_header
from avsec_gym.storage.npz_files import map_npy
from avsec_gym.storage.text_files import write_text

MARGIN = 12.5
"""Metres around the region that are kept, for scans to be turned and scaled."""

_FORMAT = 1
_STEPS = np.array([250.0, 250.0, 250.0, 32767.0])
"""Stored as whole numbers of 4 mm, a fifth of the sensor's noise, and shares of reflectance."""
_ALIKE = {"Car": ("Van",)}
"""Classes that KITTI's metric pardons when they are taken for another."""
_AGAIN = "Remove the folder; it is made anew."
_FACTS, _POINTS = "scans.json", "points.npy"
_STORED = np.dtype("<i2")
_THREADS = 2


@dataclass(frozen=True, eq=False)
class CloudSample:
    """A scan with its truth, all in the velodyne frame.

    Args:
        points: The points, shape (M, 4).
        rectangles: Objects that can be found, shape (N, 5).
        ignored: Objects that need not be found: those with hardly a point on them, and those of
            similar classes, shape (K, 5).
        azimuths: The directions between which labels are complete, as the camera sees there;
            radians from x to the left.
    """

    points: Points
    rectangles: Floats
    ignored: Floats
    azimuths: tuple[float, float]

    def mirrored(self) -> CloudSample:
        """Left and right exchanged."""
        right, left = self.azimuths
        sides = np.array([1, -1, 1, 1, -1.0])
        return CloudSample(
            self.points * np.array([1, -1, 1, 1], np.float32),
            self.rectangles * sides,
            self.ignored * sides,
            (-left, -right),
        )

    def turned(self, angle: float) -> CloudSample:
        """Turned to the left about the sensor's upright axis by an angle in radians."""
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[cos, sin], [-sin, cos]])

        def places(rows: Floats) -> Floats:
            return np.concatenate([rows[:, :2] @ turn, rows[:, 2:4], rows[:, 4:] + angle], axis=1)

        points = self.points.copy()
        points[:, :2] = points[:, :2] @ turn.astype(np.float32)
        right, left = self.azimuths
        return CloudSample(
            points, places(self.rectangles), places(self.ignored), (right + angle, left + angle)
        )

    def scaled(self, factor: float) -> CloudSample:
        """Everything larger and farther by a factor."""
        sizes = np.array([factor, factor, factor, factor, 1.0])
        return CloudSample(
            self.points * np.array([factor, factor, factor, 1], np.float32),
            self.rectangles * sizes,
            self.ignored * sizes,
            self.azimuths,
        )


class CloudSamples(LabelledFrames):
    """Cropped scans with their truth; see `prepare_cloud_samples`."""

    def __init__(self, folder: Path, places: Sequence[FramePlace]) -> None:
        super().__init__(places)
        self._facts: list[dict[str, Any]] = read_json(folder / _FACTS, remedy=_AGAIN)
        self._points = map_npy(folder / _POINTS, remedy=_AGAIN)
        self._ends = np.cumsum([0, *(fact["points"] for fact in self._facts)])

    def __getitem__(self, index: int) -> CloudSample:
        """A sample as it is."""
        fact, (start, stop) = self._facts[index], self._ends[index : index + 2]
        right, left = fact["azimuths"]
        return CloudSample(
            (self._points[start:stop] / _STEPS).astype(np.float32),
            np.reshape(fact["rectangles"], (-1, 5)),
            np.reshape(fact["ignored"], (-1, 5)),
            (right, left),
        )


def prepare_cloud_samples(
    frames: Sequence[DataFrames],
    region: BirdEyeRegion,
    category: str,
    folder: Path,
    *,
    on_progress: Progress | None = None,
) -> CloudSamples:
    """Crop scans to a region and sort their labels, unless that is done already.

    Args:
        frames: The frames, each with the files of `NEEDED`.
        region: The region of the network.
        category: What is looked for.
        folder: Where the arrays are kept, for these frames and this region.
        on_progress: Function that gets frames done and frames in all.

    Raises:
        DataError: A file is missing or broken, or there is no frame.
    """
    places = frame_places(frames, folder)
    what = (_FORMAT, region, category, MARGIN)
    files = (place.file(kind) for place in places for kind in NEEDED)
    there = folder / f"scans-{fingerprint(what, files)[:16]}"
    if not (there / _FACTS).is_file():
        with whole_folder(there) as partial:
            _write(places, region, category, partial, on_progress)
    return CloudSamples(there, places)


def cloud_sample(
    frame: SensorFrame, labels: Boxes3D, category: str, region: BirdEyeRegion
) -> CloudSample:
    """The sample of a frame.

    Args:
        frame: The frame, with a scan and image 2.
        labels: The labels of this frame.
        category: What is looked for.
        region: The region which, with `MARGIN` around it, is kept of the scan.
    """
    points, calibration = frame.points, frame.calibration
    kept = np.ones(len(points), bool)
    ranges = (region.forward, region.left, region.up)
    for values, (start, stop) in zip(points.T, ranges, strict=False):
        kept &= (values > start - MARGIN) & (values < stop + MARGIN)
    points = points[kept]
    rectangles = seen_from_above(labels, calibration)
    wanted = labels.category == category
    found = wanted & (_points_on(points, labels, frame) >= FEWEST_POINTS)
    ignored = (wanted & ~found) | np.isin(labels.category, _ALIKE.get(category, ()))
    return CloudSample(points, rectangles[found], rectangles[ignored], _azimuths(frame))


def _points_on(points: Points, boxes: Boxes3D, frame: SensorFrame) -> NDArray[np.int64]:
    """How many points lie on each box, those of the road left out, shape (N,)."""
    matrix = frame.calibration.camera_to_velodyne
    bottoms = transform_points(matrix, boxes.location)[:, 2]
    rectangles = seen_from_above(boxes, frame.calibration)
    counts = np.zeros(len(boxes), np.int64)
    for number, (bottom, height) in enumerate(zip(bottoms, boxes.dimensions[:, 0], strict=True)):
        within = (points[:, 2] > bottom + ABOVE_GROUND) & (points[:, 2] < bottom + height)
        one = rectangles[number : number + 1]
        counts[number] = (owners(points[within, :2].astype(float), one) == 0).sum()
    return counts


def _azimuths(frame: SensorFrame) -> tuple[float, float]:
    """Directions of the right and the left border of image 2, in the velodyne frame."""
    projection = frame.calibration.projection(2)
    width = frame.image(2).shape[1]
    rays = [
        np.linalg.solve(projection[:, :3], [u, projection[1, 2], 1]) for u in (width - 0.5, -0.5)
    ]
    forward, left, _ = (np.array(rays) @ frame.calibration.velodyne_to_camera[:3, :3]).T
    right_border, left_border = np.arctan2(left, forward)
    return float(right_border), float(left_border)


def _write(
    places: Sequence[FramePlace],
    region: BirdEyeRegion,
    category: str,
    folder: Path,
    on_progress: Progress | None,
) -> None:
    facts: list[dict[str, Any]] = []
    raw = folder / "points.raw"

    def sample(place: FramePlace) -> CloudSample:
        return cloud_sample(place.frame(), place.labels(), category, region)

    # First a plain file, since the number of points is known at the end only.
    with NewFile(raw) as numbers:
        with ThreadPoolExecutor(_THREADS) as threads:
            for done, cloud in enumerate(threads.map(sample, places), start=1):
                kept = np.round(cloud.points * _STEPS).clip(-32768, 32767).astype(_STORED)
                numbers.write(kept.tobytes())
                facts.append(
                    {
                        "points": len(cloud.points),
                        "rectangles": cloud.rectangles.tolist(),
                        "ignored": cloud.ignored.tolist(),
                        "azimuths": cloud.azimuths,
                    }
                )
                if on_progress is not None:
                    on_progress(done, len(places))
        count = sum(fact["points"] for fact in facts)
        with NewFile(folder / _POINTS) as array:
            array.write(npy_header(_STORED, (count, 4)))
            numbers.copy_to(array)
    raw.unlink()
    write_text(folder / _FACTS, json.dumps(facts))
