"""Calibration of a day of KITTI raw: three files beside its drives, read as one `Calibration`.

``P_rect_0i`` is the object benchmark's ``Pi``, ``R_rect_00`` its ``R0_rect``; R and T of the other
two files make its ``Tr_velo_to_cam`` and ``Tr_imu_to_velo`` (raw devkit, readme).
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats
from avsec_gym.kitti.calibration import FEWEST_CAMERAS
from avsec_gym.kitti.matrix_files import MatrixFile, MatrixShape, matrix_lines, read_matrices
from avsec_gym.storage.regular_files import is_file
from avsec_gym.storage.text_files import write_text

CAMERAS_FILE, VELODYNE_FILE, IMU_FILE = CALIBRATION_FILES = (
    "calib_cam_to_cam.txt",
    "calib_velo_to_cam.txt",
    "calib_imu_to_velo.txt",
)
"""The names of the files."""

_PROJECTION = "P_rect_"
_AGAIN = "The file may be cut off; fetch KITTI's calibration of that day again."
_TIME = "calib_time: 01-Jan-2026 00:00:00\n"  # Constant, so that equal rigs have equal files.


def read_raw_calibration(folder: str | Path) -> Calibration:
    """The calibration of a day.

    Args:
        folder: Folder of a day, such as ``2011_09_26``; without ``calib_imu_to_velo.txt``,
            `tr_imu_to_velo` is None.

    Raises:
        DataError: One of the two other files is missing, a key is missing or stands twice, a
            matrix has the wrong number of entries, a value is no finite number, or together they
            are no `Calibration`.
    """
    folder = Path(folder)
    if not is_file(folder / CAMERAS_FILE):
        raise DataError(
            f"There is no {CAMERAS_FILE}.",
            path=folder,
            remedy="KITTI offers the calibration of a day as a download of its own "
            f"({', '.join(CALIBRATION_FILES)}); put it into the folder of the date.",
        )
    cameras = read_matrices(folder / CAMERAS_FILE, _camera_shape)
    count = max(FEWEST_CAMERAS, sum(name.startswith(_PROJECTION) for name in cameras.matrices))
    names = [f"{_PROJECTION}{i:02d}" for i in range(count)]
    cameras.require([*names, "R_rect_00"], _AGAIN)
    velodyne = _rigid_file(folder / VELODYNE_FILE)
    imu = _rigid_file(folder / IMU_FILE) if is_file(folder / IMU_FILE) else None
    try:
        return Calibration(
            projections=np.stack([cameras.matrices[name] for name in names]),
            r0_rect=cameras.matrices["R_rect_00"],
            tr_velo_to_cam=_transform(velodyne),
            tr_imu_to_velo=None if imu is None else _transform(imu),
        )
    except ConfigurationError as error:
        file, key = cameras, "R_rect_00"
        if camera := re.match(r"P([0-9]+) ", str(error)):
            key = names[int(camera[1])]
        for name, other in (("tr_velo_to_cam", velodyne), ("tr_imu_to_velo", imu)):
            if other is not None and name in str(error):
                file, key = other, "R"
        raise DataError(
            f"This cannot be a calibration: {error}.",
            path=file.path,
            line=file.lines[key],
            remedy="Fetch the file again.",
        ) from error


def write_raw_calibration(
    folder: str | Path,
    calibration: Calibration,
    *,
    image_size: tuple[int, int] = (1242, 375),
    overwrite: bool = False,
) -> None:
    """Write the files of a day, lossless; pykitti reads them.

    The cameras before rectification, of which a `Calibration` does not know, are written as
    ideal: without distortion, parallel to camera 0, with the rectified images' size.

    Args:
        folder: Folder of a day, such as ``2011_09_26``.
        calibration: Calibration of any number of cameras; a camera that it lacks, and any up to the
            fourth, is written as zeros.
        image_size: Width and height, pixels.
        overwrite: Whether files that are there are replaced.

    Raises:
        DataError: A file exists and `overwrite` is false, or cannot be written.
    """
    projections = np.zeros((max(FEWEST_CAMERAS, len(calibration.projections)), 3, 4))
    projections[: len(calibration.projections)] = calibration.projections
    size = np.array(image_size, float)
    matrices: dict[str, Floats] = {"corner_dist": np.zeros(1)}
    for i, projection in enumerate(projections):
        there = projection.any()
        centre = calibration.camera_centre(i) if there else np.zeros(3)
        matrices |= {
            f"S_{i:02d}": size,
            f"K_{i:02d}": projection[:, :3],
            f"D_{i:02d}": np.zeros(5),
            f"R_{i:02d}": np.eye(3),
            f"T_{i:02d}": -calibration.r0_rect.T @ centre,
            f"S_rect_{i:02d}": size,
            f"R_rect_{i:02d}": calibration.r0_rect,
            f"{_PROJECTION}{i:02d}": projection,
        }
    folder = Path(folder)
    texts = {CAMERAS_FILE: matrix_lines(matrices, digits=7)}
    focus = matrix_lines({"delta_f": np.zeros(2), "delta_c": np.zeros(2)}, digits=7)
    texts[VELODYNE_FILE] = _rigid_text(calibration.tr_velo_to_cam) + focus
    if calibration.tr_imu_to_velo is not None:
        texts[IMU_FILE] = _rigid_text(calibration.tr_imu_to_velo)
    for name, text in texts.items():
        write_text(folder / name, _TIME + text, overwrite=overwrite)


def _camera_shape(name: str) -> MatrixShape | None:
    number = name.removeprefix(_PROJECTION)
    if number != name and len(number) == 2 and number.isascii() and number.isdecimal():
        return (3, 4)
    return (3, 3) if name == "R_rect_00" else None


def _rigid_file(path: Path) -> MatrixFile:
    shapes: dict[str, MatrixShape] = {"R": (3, 3), "T": (3, 1)}
    file = read_matrices(path, shapes.get)
    file.require(list(shapes), _AGAIN)
    return file


def _transform(file: MatrixFile) -> Floats:
    return np.hstack([file.matrices["R"], file.matrices["T"]])


def _rigid_text(transform: Floats) -> str:
    return matrix_lines({"R": transform[:, :3], "T": transform[:, 3]}, digits=7)
