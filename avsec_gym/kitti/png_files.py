"""PNG files, looked at before they are decoded, and encoded in memory before they are written."""

from __future__ import annotations

import os
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import open_regular, read_bytes

MAX_PIXELS = 64_000_000
"""A PNG that claims more is refused before memory is taken for it (KITTI: half a million)."""

GREY, INDEXED = 0, 3
"""Colour types of the PNG specification: one channel, and colours by a palette."""

_MOST_BYTES = 8 * MAX_PIXELS
_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_IHDR_END = 33
_AGAIN = "Fetch or write the file again."


@dataclass(frozen=True)
class PngHeader:
    """The header of a PNG file."""

    width: int
    height: int
    bits: int
    """Bits of a channel."""
    colour_type: int


def read_png(path: str | Path) -> tuple[PngHeader, bytes]:
    """A PNG's header and content; every chunk whole, every checksum right, the end there.

    Raises:
        DataError: Missing, empty, cut off, damaged, no PNG, or larger than `MAX_PIXELS`.
    """
    content = read_bytes(path, most=_MOST_BYTES)
    header = _header(content[:_IHDR_END], path)
    _check_chunks(content, path)
    return header, content


def read_png_header(path: str | Path) -> PngHeader:
    """A PNG's header; the end is looked at, the middle is not.

    Raises:
        DataError: Missing, empty, cut off, no PNG, or larger than `MAX_PIXELS`.
    """
    with open_regular(path, most=_MOST_BYTES) as file:
        head = file.read(_IHDR_END)
        file.seek(max(0, os.fstat(file.fileno()).st_size - 12))
        tail = file.read(12)
    header = _header(head, path)
    if tail[4:8] != b"IEND":
        raise _cut_off(path)
    return header


def decode_png(
    content: bytes, path: str | Path, flags: int, shape: tuple[int, ...]
) -> NDArray[Any]:
    """The pixels, as OpenCV gives them.

    Args:
        content: Content of the file, as `read_png` returns it.
        path: Path of the file, for messages.
        flags: Flags of ``cv2.imdecode``.
        shape: Shape that the pixels must have.

    Raises:
        DataError: They cannot be decoded, or have another shape.
    """
    import cv2  # Only here: its import takes longer than many a command.

    try:
        decoded = cv2.imdecode(np.frombuffer(content, np.uint8), flags)
    except cv2.error as error:
        raise DataError(
            f"The PNG cannot be decoded ({error}).", path=path, remedy=_AGAIN
        ) from error
    if decoded is None or decoded.shape != shape:
        raise DataError("The PNG cannot be decoded.", path=path, remedy=_AGAIN)
    return np.asarray(decoded)


def encode_png(pixels: NDArray[Any], compression: int) -> bytes:
    """A PNG in memory; equal pixels make equal bytes.

    Args:
        pixels: Pixels of shape (H, W) or, blue first, (H, W, 3); 8 or 16 bits.
        compression: Level of compression from 0 (fast) to 9 (small); beyond 1, files become 5 %
            smaller and slower.

    Raises:
        ConfigurationError: No pixels, or no such compression.
    """
    import cv2

    if not 0 <= compression <= 9:
        raise ConfigurationError(f"a PNG's compression is 0 to 9, got {compression}")
    if not 0 < pixels.shape[0] * pixels.shape[1] <= MAX_PIXELS:
        raise ConfigurationError(f"an image has 1 to {MAX_PIXELS} pixels, got {pixels.shape[:2]}")
    done, encoded = cv2.imencode(
        ".png", np.ascontiguousarray(pixels), [cv2.IMWRITE_PNG_COMPRESSION, compression]
    )
    if not done:
        raise ConfigurationError(
            f"OpenCV makes no PNG of {pixels.dtype} pixels of shape {pixels.shape}"
        )
    return bytes(encoded)


def _header(head: bytes, path: str | Path) -> PngHeader:
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
    return PngHeader(width, height, bits=head[24], colour_type=head[25])


def _check_chunks(content: bytes, path: str | Path) -> None:
    """Decoders differ in their mercy; this has none."""
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
