"""KITTI's heavy files: PNG images and BIN scans, looked at before they are trusted."""

from __future__ import annotations

import os
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.frame import Image, Points

MAX_PIXELS = 64_000_000
"""A PNG that claims more is refused before memory is taken for it (KITTI: half a million)."""
MAX_SCAN_BYTES = 512 * 2**20
"""33 million points (KITTI: 120,000, two megabytes)."""
FARTHEST_POINT = 1e6
"""Metres; a coordinate beyond this is no measurement."""

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_IHDR_END = 33
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

    content = _read(path)
    width, height = _check_header(content[:_IHDR_END], path)
    _check_chunks(content, path)
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        decoded = cv2.imdecode(np.frombuffer(content, np.uint8), flags)
    except cv2.error as error:
        raise DataError(
            f"The PNG cannot be decoded ({error}).", path=path, remedy=_AGAIN
        ) from error
    if decoded is None or decoded.shape != (height, width, 3):
        raise DataError("The PNG cannot be decoded.", path=path, remedy=_AGAIN)
    return np.ascontiguousarray(decoded[..., ::-1], np.uint8)


def read_image_size(path: str | Path) -> tuple[int, int]:
    """Width and height from the PNG's header; the end is looked at, the middle is not.

    Raises:
        DataError: Missing, empty, cut off, no PNG, larger than `MAX_PIXELS`, 16 bits.
    """
    try:
        with open(path, "rb") as file:
            head = file.read(_IHDR_END)
            file.seek(max(0, os.fstat(file.fileno()).st_size - 12))
            tail = file.read(12)
    except OSError as error:
        raise _unreadable(path, error) from error
    size = _check_header(head, path)
    if tail[4:8] != b"IEND":
        raise _cut_off(path)
    return size


def read_points(path: str | Path) -> Points:
    """A LiDAR scan, shape (M, 4) float32: x, y, z in the velodyne frame, reflectance.

    Raises:
        DataError: Missing, empty, not whole points of 16 bytes, or a value that is NaN, infinite
            or beyond `FARTHEST_POINT`.
    """
    check_scan_size(path)
    try:
        points = np.fromfile(path, "<f4").astype(np.float32, copy=False).reshape(-1, 4)
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    with np.errstate(invalid="ignore"):
        sound = (np.abs(points) <= FARTHEST_POINT).all(axis=1)
    if not sound.all():
        raise DataError(
            f"{int((~sound).sum())} of {len(points)} points hold a value that is not finite or "
            f"beyond {FARTHEST_POINT:g}; the first is point {int(sound.argmin())}.",
            path=path,
            remedy="The file is damaged, or not little-endian float32; fetch it again.",
        )
    return points


def check_scan_size(path: str | Path) -> int:
    """The number of points by the file's size, without reading it.

    Raises:
        DataError: Missing, empty, not whole points of 16 bytes, or larger than `MAX_SCAN_BYTES`.
    """
    try:
        size = os.stat(path).st_size
    except OSError as error:
        raise _unreadable(path, error) from error
    if size == 0 or size % 16 or size > MAX_SCAN_BYTES:
        problem = (
            "The scan is empty."
            if size == 0
            else f"A scan has 16 bytes for each point, this file has {size}."
            if size % 16
            else f"A scan of {size} bytes is larger than any ({MAX_SCAN_BYTES})."
        )
        raise DataError(problem, path=path, remedy="It may be cut off. " + _AGAIN)
    return size // 16


def _read(path: str | Path) -> bytes:
    try:
        size = os.stat(path).st_size
        if size > 8 * MAX_PIXELS:
            raise DataError(
                f"An image of {size} bytes is larger than any.", path=path, remedy=_AGAIN
            )
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        raise _unreadable(path, error) from error


def _check_header(head: bytes, path: str | Path) -> tuple[int, int]:
    if not head:
        raise DataError("The image file is empty.", path=path, remedy=_AGAIN)
    if head[:8] != _SIGNATURE[: len(head)]:
        raise DataError(
            "This is not a PNG.", path=path, remedy="KITTI's images are PNG; convert the file."
        )
    if len(head) < _IHDR_END:
        raise _cut_off(path)
    if head[12:16] != b"IHDR" or zlib.crc32(head[12:29]) != int.from_bytes(head[29:33]):
        raise DataError("The PNG's header is damaged.", path=path, remedy=_AGAIN)
    width, height = int.from_bytes(head[16:20]), int.from_bytes(head[20:24])
    if not 0 < width * height <= MAX_PIXELS:
        raise DataError(
            f"The PNG claims {width} x {height} pixels.",
            path=path,
            remedy=f"At most {MAX_PIXELS} pixels are decoded; KITTI's images have half a million.",
        )
    if head[24] > 8:
        raise DataError(
            f"The PNG has {head[24]} bits a channel, a camera's image 8.",
            path=path,
            remedy="Is it a disparity or depth map?",
        )
    return width, height


def _check_chunks(content: bytes, path: str | Path) -> None:
    """Every chunk whole, every checksum right, the end there; decoders differ in their mercy."""
    position = len(_SIGNATURE)
    view = memoryview(content)
    while True:
        length = int.from_bytes(content[position : position + 4])
        end = position + 12 + length
        if position + 12 > len(content) or end > len(content):
            raise _cut_off(path)
        checksum = int.from_bytes(content[end - 4 : end])
        if zlib.crc32(view[position + 4 : end - 4]) != checksum:
            raise DataError(f"The PNG is damaged near byte {position}.", path=path, remedy=_AGAIN)
        if content[position + 4 : position + 8] == b"IEND":
            return
        position = end


def _cut_off(path: str | Path) -> DataError:
    return DataError("The PNG ends before its end: it is cut off.", path=path, remedy=_AGAIN)


def _unreadable(path: str | Path, error: Exception) -> DataError:
    return DataError(
        f"The file cannot be read ({error}).",
        path=path,
        remedy="Check the path, the download and the permissions.",
    )
