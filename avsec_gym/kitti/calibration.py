"""Calibration files of the KITTI object and tracking benchmarks."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats
from avsec_gym.kitti.text_files import read_text, write_text

_SHAPES = {"R0_rect": (3, 3), "Tr_velo_to_cam": (3, 4), "Tr_imu_to_velo": (3, 4)}
_OPTIONAL = "Tr_imu_to_velo"
# The tracking benchmark says the same in other words, and without colons.
_ALIASES = {"R_rect": "R0_rect", "Tr_velo_cam": "Tr_velo_to_cam", "Tr_imu_velo": "Tr_imu_to_velo"}
_FEWEST_CAMERAS = 4


def read_calibration(path: str | Path) -> Calibration:
    """A frame's calibration.

    Args:
        path: A file with P0 to P3 (more cameras may follow), R0_rect, Tr_velo_to_cam and,
            optionally, Tr_imu_to_velo; other keys are left alone.

    Raises:
        DataError: A key is missing or stands twice, a matrix has the wrong number of entries, a
            value is not a finite number, or a rotation is none.
    """
    matrices: dict[str, Floats] = {}
    lines: dict[str, int] = {}
    for number, line in enumerate(read_text(path).split("\n"), start=1):
        words = line.split()
        if not words:
            continue
        name = words[0].removesuffix(":")
        name = _ALIASES.get(name, name)
        shape = (3, 4) if _is_camera(name) else _SHAPES.get(name)
        if shape is None:
            continue
        if name in matrices:
            raise DataError(
                f"{name} stands in line {lines[name]} already.",
                path=path,
                line=number,
                remedy="Keep one of the two.",
            )
        matrices[name] = _matrix(name, words[1:], shape, path, number)
        lines[name] = number
    cameras = max(_FEWEST_CAMERAS, sum(map(_is_camera, matrices)))
    needed = [f"P{i}" for i in range(cameras)] + [key for key in _SHAPES if key != _OPTIONAL]
    missing = [key for key in needed if key not in matrices]
    if missing:
        raise DataError(
            f"The calibration lacks {', '.join(missing)}.",
            path=path,
            line=max(lines.values(), default=0) + 1,
            remedy="The file may be cut off, or of another layout (KITTI raw has several files); "
            "fetch it again.",
        )
    try:
        return Calibration(
            projections=np.stack([matrices[f"P{i}"] for i in range(cameras)]),
            r0_rect=matrices["R0_rect"],
            tr_velo_to_cam=matrices["Tr_velo_to_cam"],
            tr_imu_to_velo=matrices.get(_OPTIONAL),
        )
    except ConfigurationError as error:
        key = next((key for key in _SHAPES if key.lower() in str(error)), "")
        raise DataError(
            f"This cannot be a calibration: {error}.",
            path=path,
            line=lines.get(key),
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
    lines = [
        f"{name}: {' '.join(_word(value) for value in matrix.ravel().tolist())}\n"
        for name, matrix in matrices.items()
    ]
    write_text(path, "".join(lines) + "\n", overwrite=overwrite)


def _is_camera(name: str) -> bool:
    return name[:1] == "P" and name[1:].isascii() and name[1:].isdigit()


def _matrix(
    name: str, words: list[str], shape: tuple[int, int], path: str | Path, line: int
) -> Floats:
    count = shape[0] * shape[1]
    if len(words) != count:
        raise DataError(
            f"{name} has {count} entries, this one {len(words)}.",
            path=path,
            line=line,
            remedy="The line may be cut off; fetch the file again.",
        )
    try:
        values = np.array([float(word) for word in words])
    except ValueError as error:
        raise DataError(
            f"{name} holds something that is not a number ({error}).",
            path=path,
            line=line,
            remedy="Correct the line, or fetch the file again.",
        ) from error
    if not np.isfinite(values).all() or np.abs(values).max() > 1e9:
        raise DataError(
            f"{name} holds a number that is not finite or too large to be true.",
            path=path,
            line=line,
            remedy="Correct the line, or fetch the file again.",
        )
    return values.reshape(shape)


def _word(value: float) -> str:
    thirteen_digits = f"{value:.12e}"
    return thirteen_digits if float(thirteen_digits) == value else repr(value)
