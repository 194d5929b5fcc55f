"""`CropMessage`: what a vehicle scanned in every region, on its way to the base station."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.messages.message_bytes import (
    CENTIMETRE,
    HEADER_BYTES,
    HeaderKind,
    check_length,
    column,
    header,
    read_header,
    refused,
    whole_number_bytes,
)
from avsec_gym.validation.connected.messages.region_message import MOST_REGIONS

MOST_POINTS = 500_000
"""Most points of all crops of a message together: more than two mirrored scans hold."""
_POINT_BYTES = 6
_COUNT_BYTES = 4


@dataclass(frozen=True, eq=False)
class CropMessage:
    """The points of each region of the complete set, in the region's own frame.

    Bytes are exact to 5 mm.

    Args:
        sender: Number of the vehicle.
        crops: An array (M, 3) for each region, in the order of the base station, metres.
    """

    sender: int
    crops: tuple[Floats, ...]

    @property
    def nbytes(self) -> int:
        """Exact length of its bytes."""
        points = sum(len(crop) for crop in self.crops)
        return HEADER_BYTES + _COUNT_BYTES * len(self.crops) + _POINT_BYTES * points

    def to_bytes(self) -> bytes:
        """The message as it is sent.

        Raises:
            DataError: Too many regions or points, or a point farther than 327 m from its region.
        """
        counts = np.array([len(crop) for crop in self.crops], np.int64)
        if len(counts) > MOST_REGIONS or counts.sum() > MOST_POINTS:
            raise refused(
                f"{len(counts)} crops with {counts.sum()} points, at most {MOST_REGIONS} with"
                f" {MOST_POINTS} are sent"
            )
        points = np.concatenate(self.crops) if len(counts) else np.zeros((0, 3))
        return (
            header(HeaderKind.CROPS, self.sender, len(counts))
            + counts.astype("<u4").tobytes()
            + whole_number_bytes(points, CENTIMETRE, "<i2")
        )

    @classmethod
    def from_bytes(cls, content: bytes) -> CropMessage:
        """The inverse of `to_bytes`.

        Raises:
            DataError: The bytes are no such message.
        """
        sender, count = read_header(content, HeaderKind.CROPS, MOST_REGIONS)
        start = HEADER_BYTES + _COUNT_BYTES * count
        if len(content) < start:
            raise refused(f"it ends within the counts of its {count} crops")
        counts = column(content, "<u4", count, HEADER_BYTES).astype(np.int64)
        total = int(counts.sum())
        if total > MOST_POINTS:
            raise refused(f"it promises {total} points, at most {MOST_POINTS} are taken")
        check_length(content, start + _POINT_BYTES * total)
        points = column(content, "<i2", 3 * total, start).reshape(total, 3) * CENTIMETRE
        ends = np.cumsum(counts)
        crops = tuple(points[end - size : end] for end, size in zip(ends, counts, strict=True))
        return cls(sender, crops)
