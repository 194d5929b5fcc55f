"""The message in which a vehicle sends its claims: a few kilobytes, read with distrust.

A header of the format's number (1 byte) and the number of claims (2 bytes); for each claim its
region (2 bytes), velocity (two times 2 bytes, in hundredths of a metre a second), number of
voxels (1 byte) and time (2 bytes, signed, in 2 ms); then all voxels: the first of a claim, and of
each further one how far it lies after the one before, as numbers of 7 bits a byte of which the last
has its highest bit clear.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.rays.claims import (
    MARGIN,
    MOST_CLAIMS,
    MOST_VOXELS,
    MOST_VOXELS_OF_ONE,
    SEARCHED,
    Claims,
    grid_shapes,
)
from avsec_gym.validation.connected.regions import Regions

_FORMAT = 3
_HEADER, _CLAIM = struct.Struct("<BH"), struct.Struct("<HhhBh")
VELOCITY_STEP = 0.01
"""Precision of velocities in a message, m/s."""
TIME_STEP = 0.002
"""Precision of times in a message, seconds."""
MOST_BYTES = _HEADER.size + MOST_CLAIMS * _CLAIM.size + 3 * MOST_VOXELS
"""Most bytes of a message; what is longer is none."""
_MOST_TIME_STEPS = 32767
"""Two bytes, with their sign."""
_MOST_VOXEL = 1 << 21
"""Voxels of a region that three bytes can number."""


def encode_claims(claims: Claims) -> bytes:
    """A vehicle's claims as a message.

    Raises:
        DataError: A region has more voxels than a message can number, or a claim's time is farther
            from the instant than it can hold.
    """
    times = np.round(claims.time / TIME_STEP).astype(np.int64)
    if (np.abs(times) > _MOST_TIME_STEPS).any():
        raise DataError(
            f"A claim of {np.abs(claims.time).max():.3f} s beside the instant does not fit into a "
            f"message, which holds up to {_MOST_TIME_STEPS * TIME_STEP:g} s.",
            remedy="Compare instants with scans that are taken within a minute of them.",
        )
    rows = zip(claims.region, _steps(claims), claims.count, times, strict=True)
    header = _HEADER.pack(_FORMAT, len(claims))
    table = b"".join(_CLAIM.pack(region, x, y, count, when) for region, (x, y), count, when in rows)
    first = np.cumsum(claims.count) - claims.count
    gaps = np.diff(claims.voxel, prepend=0)
    gaps[first] = claims.voxel[first]
    return header + table + _to_bytes(gaps)


def decode_claims(message: bytes, regions: Regions, *, at_intervals: bool = False) -> Claims:
    """The claims of a message.

    Args:
        message: What `encode_claims` wrote, or anything else that came in.
        regions: The regions that all vehicles share.
        at_intervals: Whether scans are taken at intervals, so that claims may be of any time.

    Raises:
        DataError: The message is no such message, claims more than a vehicle may, claims something
            outside of these regions, or something of another time than the instant's.
    """
    if not _HEADER.size <= len(message) <= MOST_BYTES:
        raise _refused(f"it has {len(message)} bytes")
    version, number = _HEADER.unpack_from(message)
    begin = _HEADER.size + number * _CLAIM.size
    if version != _FORMAT or number > MOST_CLAIMS or begin > len(message):
        raise _refused(f"it begins with format {version} and {number} claims")
    rows = [_CLAIM.unpack_from(message, _HEADER.size + i * _CLAIM.size) for i in range(number)]
    table = np.array(rows, np.int64).reshape(-1, 5)
    region, count = table[:, 0], table[:, 3]
    if (np.diff(region) <= 0).any() or (region >= len(regions)).any():
        raise _refused("its regions do not rise, or are none of those that were sent to all")
    if (count < 1).any() or (count > MOST_VOXELS_OF_ONE).any() or count.sum() > MOST_VOXELS:
        raise _refused(f"it claims {count.sum()} voxels")
    time = np.asarray(TIME_STEP * table[:, 4])
    if not at_intervals and (np.abs(time) > SEARCHED).any():
        raise _refused(f"it claims what was there {np.abs(time).max():.3f} s beside the instant")
    gaps = _from_bytes(message[begin:], int(count.sum()))
    # Voxels rise within each claim, and stay inside the region's box.
    first = np.cumsum(count) - count
    total = np.cumsum(gaps)
    before = np.repeat(total[first] - gaps[first], count)
    voxel = total - before
    later = np.ones(len(gaps), bool)
    later[first] = False
    size = regions.grown(MARGIN, MARGIN).size[region]
    room = np.repeat(grid_shapes(size).prod(axis=1), count)
    if (gaps[later] < 1).any() or (voxel >= room).any():
        raise _refused("it claims something outside of a region")
    velocity = np.asarray(VELOCITY_STEP * table[:, 1:3])
    return Claims(region, velocity, count, voxel, time)


def _refused(reason: str) -> DataError:
    return DataError(
        f"This is no message of claims: {reason}.",
        remedy="Leave the vehicle that sent it out of this instant.",
    )


def _steps(claims: Claims) -> list[list[int]]:
    """Velocities in steps; what is faster than a message can hold is cut off."""
    whole = np.round(claims.velocity / VELOCITY_STEP)
    return np.clip(whole, -32767, 32767).astype(np.int64).tolist()


def _to_bytes(numbers: NDArray[np.int64]) -> bytes:
    if len(numbers) and not 0 <= numbers.min() <= numbers.max() < _MOST_VOXEL:
        raise DataError("a region has more voxels than a message can number")
    parts = np.stack([numbers & 127, numbers >> 7 & 127, numbers >> 14], axis=1)
    length = 1 + (numbers > 127) + (numbers > 16383)
    place = np.arange(3)
    used = place < length[:, None]
    more = place < length[:, None] - 1
    return bytes((parts + 128 * more)[used].astype(np.uint8))


def _from_bytes(content: bytes, number: int) -> NDArray[np.int64]:
    raw = np.frombuffer(content, np.uint8).astype(np.int64)
    ends = np.flatnonzero(raw < 128)
    if len(ends) != number or (number and ends[-1] != len(raw) - 1) or (not number and len(raw)):
        raise _refused("its voxels are cut off, or too many")
    begins = np.concatenate([[0], ends[:-1] + 1])[:number]
    if (ends - begins > 2).any():
        raise _refused("a voxel has a number of more than three bytes")
    place = np.arange(len(raw)) - np.repeat(begins, ends - begins + 1)
    return np.asarray(np.add.reduceat((raw & 127) << (7 * place), begins)) if number else raw
