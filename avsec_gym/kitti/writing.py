"""Frames written in KITTI's layouts, so that every reader here, and any KITTI tool, loads them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.kitti.calibration import write_calibration
from avsec_gym.kitti.label_folders import check_id
from avsec_gym.kitti.labels import write_labels
from avsec_gym.kitti.oxts import Oxts, write_oxts
from avsec_gym.kitti.raw import OXTS, TRACKLETS, VELODYNE, raw_file
from avsec_gym.kitti.sensor_files import write_image, write_points
from avsec_gym.kitti.timestamps import Timestamps, write_timestamps
from avsec_gym.kitti.tracklets import Tracklet, write_tracklets

_GREY_CAMERAS = (0, 1)
_MOST_PREVIOUS = 3


def write_object_frame(
    folder: str | Path,
    frame: SensorFrame,
    labels: Boxes3D | None = None,
    *,
    compression: int = 1,
    overwrite: bool = False,
) -> None:
    """Write a frame of the object benchmark.

    Images, ``prev_N`` of up to three earlier frames, the scan, then calibration, and the label
    last: a frame that has one is complete, however the writing was interrupted.

    Args:
        folder: The object layout's folder, such as ``training``.
        frame: The frame, whose id has six digits; images and scan are written where it has them.
        labels: The ground truth; no label file if None.
        compression: Level of compression of the images, 0 (fast) to 9 (small).
        overwrite: Whether files that are there are replaced.

    Raises:
        ConfigurationError: The id is not six digits, or an image or scan cannot be written.
        DataError: A file exists and `overwrite` is false, or cannot be written.
    """
    folder, id = Path(folder), check_id(frame.id)
    _write_images(
        {folder / f"image_{i}" / f"{id}.png": (i, image) for i, image in frame.images.items()},
        compression,
        overwrite,
    )
    for step, earlier in enumerate(frame.previous[:_MOST_PREVIOUS], start=1):
        name = f"{id}_{step:02d}.png"
        _write_images(
            {folder / f"prev_{i}" / name: (i, image) for i, image in earlier.images.items()},
            compression,
            overwrite,
        )
    if frame.has_points:
        write_points(folder / "velodyne" / f"{id}.bin", frame.points, overwrite=overwrite)
    write_calibration(folder / "calib" / f"{id}.txt", frame.calibration, overwrite=overwrite)
    if labels is not None:
        write_labels(folder / "label_2" / f"{id}.txt", labels, overwrite=overwrite)


def write_raw_frame(
    folder: str | Path,
    number: int,
    frame: SensorFrame,
    *,
    compression: int = 1,
    overwrite: bool = False,
) -> None:
    """Write images and scan of a frame of a drive.

    The rest of a drive is written by `write_raw_calibration` and `write_drive_records`.

    Args:
        folder: The drive, such as ``2026_01_01/2026_01_01_drive_0001_sync``.
        number: The frame's number, from 0.
        frame: Images and scan are written where it has them.
        compression: Level of compression of the images, 0 (fast) to 9 (small).
        overwrite: Whether files that are there are replaced.

    Raises:
        ConfigurationError: An image or scan cannot be written, or the number is negative.
        DataError: A file exists and `overwrite` is false, or cannot be written.
    """
    folder = Path(folder)
    _write_images(
        {
            raw_file(folder, f"image_{i:02d}", number): (i, image)
            for i, image in frame.images.items()
        },
        compression,
        overwrite,
    )
    if frame.has_points:
        write_points(raw_file(folder, VELODYNE, number), frame.points, overwrite=overwrite)


def write_drive_records(
    folder: str | Path,
    *,
    oxts: Oxts | None = None,
    timestamps: Mapping[str, Timestamps] | None = None,
    tracklets: Sequence[Tracklet] | None = None,
    overwrite: bool = False,
) -> None:
    """Write what a drive has besides images and scans.

    Args:
        folder: The drive.
        oxts: Measurements, one for each frame from 0 on.
        timestamps: Timestamps by sensor, such as ``oxts``, ``image_02``, ``velodyne_points``.
        tracklets: The labelled objects.
        overwrite: Whether files that are there are replaced.

    Raises:
        ConfigurationError: Timestamps are none.
        DataError: A file exists and `overwrite` is false, or cannot be written.
    """
    folder = Path(folder)
    for sensor, times in (timestamps or {}).items():
        write_timestamps(folder / sensor / "timestamps.txt", times, overwrite=overwrite)
    if oxts is not None:
        write_oxts(folder / OXTS / "data", oxts, overwrite=overwrite)
    if tracklets is not None:
        write_tracklets(folder / TRACKLETS, tracklets, overwrite=overwrite)


def _write_images(
    images: Mapping[Path, tuple[int, Image]], compression: int, overwrite: bool
) -> None:
    for path, (camera, image) in images.items():
        grey = camera in _GREY_CAMERAS
        write_image(path, image, grey=grey, compression=compression, overwrite=overwrite)
