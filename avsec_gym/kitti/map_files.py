"""Maps as one-channel PNGs: disparities as in KITTI's stereo benchmarks, and label masks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.png_files import GREY, INDEXED, decode_png, encode_png, read_png
from avsec_gym.storage.atomic_write import write_bytes

Disparity = NDArray[np.float32]
"""Shape (H, W), pixels; NaN where unknown."""
Mask = NDArray[np.uint8] | NDArray[np.uint16]
"""Shape (H, W): a number for each pixel."""

_SCALE = 256.0
_LARGEST = 65535 / _SCALE


def read_disparity(path: str | Path) -> Disparity:
    """A disparity map such as those of ``disp_occ`` and ``disp_occ_0``.

    Returns:
        Shape (H, W) float32, pixels; NaN where unknown (0 in the file).

    Raises:
        DataError: Missing, cut off, damaged, no PNG, or not one channel of 16 bits.
    """
    stored = _read(path)
    if stored.dtype != np.uint16:
        raise DataError(
            "The PNG has 8 bits, a disparity map 16.",
            path=path,
            remedy="Is it a camera's image, or a picture of a disparity map?",
        )
    disparity = stored.astype(np.float32) / np.float32(_SCALE)
    disparity[stored == 0] = np.nan
    return disparity


def write_disparity(
    path: str | Path, disparity: Disparity, *, compression: int = 1, overwrite: bool = False
) -> None:
    """Write a disparity map: rounded to 1/256 pixel, at least that, and 0 where NaN.

    Args:
        path: The file.
        disparity: Disparity in pixels, in [0, 255.99], shape (H, W); NaN where unknown.
        compression: Level of compression from 0 (fast) to 9 (small).
        overwrite: Whether a file that is there is replaced.

    Raises:
        ConfigurationError: Another shape, or a disparity that the format cannot hold.
        DataError: The file exists and `overwrite` is false, or cannot be written.
    """
    disparity = np.asarray(disparity, np.float32)
    known = ~np.isnan(disparity)
    beyond = known & ~((disparity >= 0) & (disparity <= _LARGEST))
    if disparity.ndim != 2 or beyond.any():
        raise ConfigurationError(
            f"a disparity map has shape (H, W) and values in [0, {_LARGEST:.2f}] or NaN, got "
            f"shape {disparity.shape} with {int(beyond.sum())} values beyond"
        )
    stored = np.zeros(disparity.shape, np.uint16)
    stored[known] = np.maximum(np.round(disparity[known] * _SCALE), 1)
    write_bytes(path, encode_png(stored, compression), overwrite=overwrite)


def read_mask(path: str | Path) -> Mask:
    """A mask as it was written, uint8 or uint16.

    Raises:
        DataError: Missing, cut off, damaged, no PNG, or not one channel of 8 or 16 bits.
    """
    return _read(path)


def write_mask(
    path: str | Path, mask: Mask, *, compression: int = 1, overwrite: bool = False
) -> None:
    """Write a mask with 8 bits a pixel if it is uint8, with 16 if it is uint16.

    Raises:
        ConfigurationError: Another type or shape.
        DataError: The file exists and `overwrite` is false, or cannot be written.
    """
    if mask.ndim != 2 or mask.dtype not in (np.uint8, np.uint16):
        raise ConfigurationError(
            f"a mask is uint8 or uint16 of shape (H, W), got {mask.dtype} of {mask.shape}"
        )
    write_bytes(path, encode_png(mask, compression), overwrite=overwrite)


def _read(path: str | Path) -> NDArray[Any]:
    import cv2  # Only here: its import takes longer than many a command.

    header, content = read_png(path)
    if header.colour_type != GREY or header.bits not in (8, 16):
        kind = "a palette" if header.colour_type == INDEXED else f"{header.bits} bits a channel"
        raise DataError(
            f"A map has one channel of 8 or 16 bits, this PNG {kind} in colour type "
            f"{header.colour_type}.",
            path=path,
            remedy="Is it a camera's image, or a coloured picture of a map?",
        )
    return decode_png(content, path, cv2.IMREAD_UNCHANGED, (header.height, header.width))
