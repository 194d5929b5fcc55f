"""`RegionMessage`: proposals with their sender's pose, and the complete set on its way back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.validation.connected.messages.message_bytes import (
    CENTIMETRE,
    HEADER_BYTES,
    POSE_BYTES,
    HeaderKind,
    check_length,
    column,
    header,
    pose_bytes,
    read_header,
    read_pose_bytes,
    refused,
    whole_number_bytes,
)
from avsec_gym.validation.connected.regions import Regions

MOST_REGIONS = 1024
BASE_STATION = 65535
"""Its number as a sender."""
REGION_BYTES = 14
_ANGLE = np.pi / 32768


@dataclass(frozen=True, eq=False)
class RegionMessage:
    """Regions in the frame of the sender, and the frame's pose Tr = (R, t) in the world.

    Bytes are exact to 5 mm in places and sizes, 0.5 mm in the position of the frame, and 5e-5
    radians in headings.

    Args:
        sender: Number of the vehicle, or `BASE_STATION`.
        pose: Transform from the sender's frame to the world, shape (4, 4).
        regions: The regions, in the sender's frame.
    """

    sender: int
    pose: Floats
    regions: Regions

    @property
    def nbytes(self) -> int:
        """Exact length of its bytes."""
        return HEADER_BYTES + POSE_BYTES + REGION_BYTES * len(self.regions)

    def to_bytes(self) -> bytes:
        """The message as it is sent.

        Raises:
            DataError: More than `MOST_REGIONS`, or one farther than 327 m from the sender.
        """
        regions = self.regions
        if len(regions) > MOST_REGIONS:
            raise refused(f"{len(regions)} regions, at most {MOST_REGIONS} are sent")
        # -pi has a place in 16 bits, pi is the same direction.
        heading = np.round(wrap_angle(regions.heading) / _ANGLE)
        heading = np.where(heading > 32767, -32768, heading)
        return (
            header(HeaderKind.REGIONS, self.sender, len(regions))
            + pose_bytes(self.pose)
            + whole_number_bytes(regions.centre, CENTIMETRE, "<i2")
            + whole_number_bytes(np.maximum(regions.size, CENTIMETRE), CENTIMETRE, "<u2")
            + heading.astype("<i2").tobytes()
        )

    @classmethod
    def from_bytes(cls, content: bytes) -> RegionMessage:
        """The inverse of `to_bytes`.

        Raises:
            DataError: The bytes are no such message, or it holds what is no region.
        """
        sender, count = read_header(content, HeaderKind.REGIONS, MOST_REGIONS)
        check_length(content, HEADER_BYTES + POSE_BYTES + REGION_BYTES * count)
        pose = read_pose_bytes(content, HEADER_BYTES)
        start = HEADER_BYTES + POSE_BYTES
        centre = column(content, "<i2", 3 * count, start).reshape(count, 3) * CENTIMETRE
        size = column(content, "<u2", 3 * count, start + 6 * count).reshape(count, 3) * CENTIMETRE
        heading = column(content, "<i2", count, start + 12 * count) * _ANGLE
        return cls(sender, pose, Regions(centre, size, heading))
