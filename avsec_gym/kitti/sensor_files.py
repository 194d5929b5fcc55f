"""KITTI's heavy files, read and written: a camera's PNG images, a LiDAR's BIN scans."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Image, Points
from avsec_gym.kitti.png_files import (
    PngHeader,
    decode_png,
    encode_png,
    read_png,
    read_png_header,
)
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.regular_files import check_regular, read_bytes

MAX_SCAN_BYTES = 512 * 2**20
"""33 million points (KITTI: 120,000, two megabytes)."""
FARTHEST_POINT = 1000.0
"""Metres; a coordinate beyond this is no measurement of a car's LiDAR."""

_AGAIN = "Fetch or write the file again."


@dataclass(frozen=True)
class ImageFile:
    """Loads an image when called; survives the way to a worker process."""

    path: Path

    def __call__(self) -> Image:
        """See `read_image`."""
        return read_image(self.path)


@dataclass(frozen=True)
class ScanFile:
    """Loads a scan when called; survives the way to a worker process."""

    path: Path

    def __call__(self) -> Points:
        """See `read_points`."""
        return read_points(self.path)


def read_image(path: str | Path) -> Image:
    """A camera's PNG as RGB, shape (H, W, 3); grey images get three equal channels.

    Raises:
        DataError: Missing, empty, cut off, damaged, no PNG, larger than `MAX_PIXELS`, 16 bits.
    """
    import cv2  # Only here: its import takes longer than many a command.

    header, content = read_png(path)
    _check_bits(header, path)
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    decoded = decode_png(content, path, flags, (header.height, header.width, 3))
    return np.ascontiguousarray(decoded[..., ::-1], np.uint8)


def read_image_size(path: str | Path) -> tuple[int, int]:
    """Width and height from the PNG's header; the end is looked at, the middle is not.

    Raises:
        DataError: Missing, empty, cut off, no PNG, larger than `MAX_PIXELS`, 16 bits.
    """
    header = read_png_header(path)
    _check_bits(header, path)
    return header.width, header.height


def write_image(
    path: str | Path,
    image: Image,
    *,
    grey: bool = False,
    compression: int = 1,
    overwrite: bool = False,
) -> None:
    """Write a camera's PNG, lossless.

    Args:
        path: The file.
        image: Image in red, green, blue, shape (H, W, 3).
        grey: Store one channel, as KITTI does for cameras 0 and 1: the mean of the three.
        compression: Level of compression from 0 (fast) to 9 (small).
        overwrite: Whether a file that is there is replaced.

    Raises:
        ConfigurationError: The image is not 8-bit RGB, has no pixels, or no such compression.
        DataError: The file exists and `overwrite` is false, or cannot be written.
    """
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise ConfigurationError(
            f"an image is uint8 of shape (H, W, 3), got {image.dtype} of {image.shape}"
        )
    pixels = image.mean(axis=2).round().astype(np.uint8) if grey else image[..., ::-1]
    write_bytes(path, encode_png(pixels, compression), overwrite=overwrite)


def read_points(path: str | Path) -> Points:
    """A LiDAR scan, shape (M, 4) float32: x, y, z in the velodyne frame, reflectance.

    Raises:
        DataError: Missing, empty, not whole points of 16 bytes, a coordinate that is NaN, infinite
            or beyond `FARTHEST_POINT`, or a reflectance that is not from 0 to 1.
    """
    content = bytearray(read_bytes(path, most=MAX_SCAN_BYTES))  # Arrays on it can be written.
    _check_size(path, len(content))
    points = np.frombuffer(content, "<f4").astype(np.float32, copy=False).reshape(-1, 4)
    sound = _are_points(points)
    if not sound.all():
        near = (np.abs(points[:, :3]) <= FARTHEST_POINT).all()
        what = (
            "reflectance that is not from 0 to 1"
            if near
            else f"coordinate that is not finite or beyond {FARTHEST_POINT:g} m"
        )
        raise DataError(
            f"{int((~sound).sum())} of {len(points)} points hold a {what}; the first is point "
            f"{int(sound.argmin())}.",
            path=path,
            remedy="KITTI's are; divide those of other sensors by their largest, such as 255."
            if near
            else "The file is damaged, or not little-endian float32; fetch it again.",
        )
    return points


def check_scan_size(path: str | Path) -> int:
    """The number of points by the file's size, without reading it.

    Raises:
        DataError: Missing, empty, not whole points of 16 bytes, or larger than `MAX_SCAN_BYTES`.
    """
    size = check_regular(path, most=MAX_SCAN_BYTES)
    _check_size(path, size)
    return size // 16


def write_points(path: str | Path, points: Points, *, overwrite: bool = False) -> None:
    """Write a LiDAR scan as little-endian float32.

    Raises:
        ConfigurationError: Not of shape (M, 4), no points, or a value that `read_points` refuses.
        DataError: The file exists and `overwrite` is false, or cannot be written.
    """
    points = np.asarray(points, np.float32)
    if points.ndim != 2 or points.shape[1] != 4 or not len(points):
        raise ConfigurationError(f"a scan has shape (M, 4) with M > 0, got {points.shape}")
    if not _are_points(points).all():
        raise ConfigurationError(
            "a scan holds a coordinate that is not finite or too far away, or a reflectance that "
            "is not from 0 to 1"
        )
    write_bytes(path, points.astype("<f4").tobytes(), overwrite=overwrite)


def _are_points(points: Points) -> NDArray[np.bool_]:
    """Which rows can be measurements, shape (M,); NaN is none."""
    near = (np.abs(points[:, :3]) <= FARTHEST_POINT).all(axis=1)
    return np.asarray(near & (points[:, 3] >= 0) & (points[:, 3] <= 1))


def _check_size(path: str | Path, size: int) -> None:
    if size == 0 or size % 16:
        problem = f"A scan has 16 bytes for each point, this file has {size}."
        raise DataError(
            problem if size else "The scan is empty.",
            path=path,
            remedy="It may be cut off. " + _AGAIN,
        )


def _check_bits(header: PngHeader, path: str | Path) -> None:
    if header.bits > 8:
        raise DataError(
            f"The PNG has {header.bits} bits a channel, a camera's image 8.",
            path=path,
            remedy="Is it a disparity or depth map?",
        )
