"""Calibration files of the KITTI object, tracking and odometry benchmarks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats
from avsec_gym.kitti.matrix_files import matrix_lines, read_matrices
from avsec_gym.storage.text_files import write_text

FEWEST_CAMERAS = 4
"""KITTI's files always speak of cameras 0 to 3."""

_SHAPES = {"R0_rect": (3, 3), "Tr_velo_to_cam": (3, 4), "Tr_imu_to_velo": (3, 4)}
_OPTIONAL = "Tr_imu_to_velo"
# The tracking benchmark has other names for the same, and no colons.
_ODOMETRY = "Put the calib.txt of data_odometry_calib.zip in its place, which has a line Tr, too."
_ALIASES = {"R_rect": "R0_rect", "Tr_velo_cam": "Tr_velo_to_cam", "Tr_imu_velo": "Tr_imu_to_velo"}


def read_calibration(path: str | Path) -> Calibration:
    """A frame's calibration.

    Args:
        path: A file with P0 to P3 (more cameras may follow), R0_rect, Tr_velo_to_cam and,
            optionally, Tr_imu_to_velo; other keys are left alone.

    Raises:
        DataError: A key is missing or stands twice, a matrix has the wrong number of entries, a
            value is not a finite number, or together they are no `Calibration`.
    """
    return _calibration(path, _ALIASES, {})


def read_odometry_calibration(path: str | Path) -> Calibration:
    """Calibration of a sequence of the odometry benchmark.

    Args:
        path: ``calib.txt`` with P0 to P3 and Tr, from the LiDAR to the rectified camera 0.

    Raises:
        DataError: As of `read_calibration`.  The archives of images hold such files without Tr:
            then its remedy names the archive that has it.
    """
    identity = {"R0_rect": np.eye(3)}
    return _calibration(path, {"Tr": "Tr_velo_to_cam"}, identity, _ODOMETRY)


def _calibration(
    path: str | Path,
    aliases: Mapping[str, str],
    given: Mapping[str, Floats],
    remedy: str = "The file may be cut off, or of another layout (KITTI raw has several files); "
    "fetch it again.",
) -> Calibration:
    """A file's matrices, and those that its benchmark does not write because all have them."""
    file = read_matrices(
        path, lambda name: (3, 4) if _is_camera(name) else _SHAPES.get(name), aliases
    )
    file.matrices.update({name: own for name, own in given.items() if name not in file.matrices})
    matrices = file.matrices
    cameras = [f"P{i}" for i in range(max(FEWEST_CAMERAS, sum(map(_is_camera, matrices))))]
    file.require([*cameras, *(key for key in _SHAPES if key != _OPTIONAL)], remedy)
    try:
        return Calibration(
            projections=np.stack([matrices[name] for name in cameras]),
            r0_rect=matrices["R0_rect"],
            tr_velo_to_cam=matrices["Tr_velo_to_cam"],
            tr_imu_to_velo=matrices.get(_OPTIONAL),
        )
    except ConfigurationError as error:
        key = next((key for key in file.lines if f"{key.lower()} " in f"{error} ".lower()), "")
        raise DataError(
            f"This cannot be a calibration: {error}.",
            path=path,
            line=file.lines.get(key),
            remedy="Fetch the file again.",
        ) from error


def write_calibration(
    path: str | Path, calibration: Calibration, *, overwrite: bool = False
) -> None:
    """Write a calibration file, lossless; KITTI's own come out byte for byte.

    Raises:
        DataError: The file exists and `overwrite` is false, or cannot be written.
    """
    matrices = {f"P{i}": matrix for i, matrix in enumerate(calibration.projections)}
    matrices["R0_rect"] = calibration.r0_rect
    matrices["Tr_velo_to_cam"] = calibration.tr_velo_to_cam
    if calibration.tr_imu_to_velo is not None:
        matrices[_OPTIONAL] = calibration.tr_imu_to_velo
    write_text(path, matrix_lines(matrices, digits=13) + "\n", overwrite=overwrite)


def _is_camera(name: str) -> bool:
    return name[:1] == "P" and name[1:].isascii() and name[1:].isdecimal()
