"""Messages as bytes: a header, then columns of numbers, refused unless they are exactly as long.

A message comes from another vehicle, which may be broken or may lie: its length is compared with
what its header promises before anything is made of it.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy.spatial.transform import Rotation

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats

_MAGIC = b"AV"
_VERSION = 1
_HEADER = struct.Struct("<2sBBHI")
HEADER_BYTES = _HEADER.size
POSE_BYTES = 24
MILLIMETRE = 1e-3
CENTIMETRE = 1e-2
_REMEDY = "Leave this message out: its sender is broken, or does not mean well."


class HeaderKind(IntEnum):
    """What a message is; the number stands in its header."""

    REGIONS = 1
    CROPS = 2


def refused(problem: str) -> DataError:
    """The error of a message that cannot be read, or cannot be sent."""
    return DataError(f"This is no message of connected vehicles: {problem}.", remedy=_REMEDY)


def header(kind: HeaderKind, sender: int, count: int) -> bytes:
    """The beginning of a message.

    Raises:
        DataError: The sender's number has no place in 16 bits.
    """
    if not 0 <= sender < 1 << 16:
        raise refused(f"a sender has a number from 0 to 65535, not {sender}")
    return _HEADER.pack(_MAGIC, _VERSION, kind, sender, count)


def read_header(content: bytes, kind: HeaderKind, most: int) -> tuple[int, int]:
    """The sender and the count of a message.

    Raises:
        DataError: It is cut off, of another kind or version, or promises more than `most`.
    """
    if len(content) < HEADER_BYTES:
        raise refused(f"it has {len(content)} bytes, its header alone {HEADER_BYTES}")
    magic, version, found, sender, count = _HEADER.unpack_from(content)
    if magic != _MAGIC or version != _VERSION or found != kind:
        raise refused(f"it does not begin as one of {kind.name.lower()}, version {_VERSION}")
    if count > most:
        raise refused(f"it promises {count} {kind.name.lower()}, at most {most} are taken")
    return sender, count


def check_length(content: bytes, expected: int) -> None:
    """Refuse a message that is shorter or longer than its header promises.

    Raises:
        DataError: It is.
    """
    if len(content) != expected:
        raise refused(f"it has {len(content)} bytes and promises {expected}")


def column(content: bytes, kind: DTypeLike, count: int, offset: int) -> NDArray[Any]:
    """Numbers of a message whose length was checked."""
    return np.frombuffer(content, kind, count, offset)


def whole_number_bytes(values: Floats, unit: float, kind: DTypeLike) -> bytes:
    """Whole numbers of a unit, such as centimetres, as bytes.

    Raises:
        DataError: A value is not finite, or has no place in this kind of number.
    """
    whole = np.round(np.asarray(values, np.float64) / unit)
    limits = np.iinfo(np.dtype(kind))
    if not ((whole >= limits.min) & (whole <= limits.max)).all():
        raise refused(f"numbers are from {limits.min * unit:g} to {limits.max * unit:g}")
    return whole.astype(kind).tobytes()


def pose_bytes(pose: Floats) -> bytes:
    """A rigid transform: a position in millimetres, a rotation vector in float32.

    Raises:
        DataError: The position is more than 2,147 km away.
    """
    turned = Rotation.from_matrix(pose[:3, :3]).as_rotvec()
    return whole_number_bytes(pose[:3, 3], MILLIMETRE, "<i4") + turned.astype("<f4").tobytes()


def read_pose_bytes(content: bytes, offset: int) -> Floats:
    """The inverse of `pose_bytes`: always a rigid transform, shape (4, 4).

    Raises:
        DataError: The rotation is not finite, or more than a whole turn.
    """
    turned = column(content, "<f4", 3, offset + 12).astype(np.float64)
    if not np.isfinite(turned).all() or np.linalg.norm(turned) > 2 * np.pi:
        raise refused("its pose is no rigid transform")
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(turned).as_matrix()
    pose[:3, 3] = column(content, "<i4", 3, offset).astype(np.float64) * MILLIMETRE
    return pose
