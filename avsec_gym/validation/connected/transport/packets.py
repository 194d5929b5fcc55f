"""Packets: a message with its place in an instant, its length and a checksum, in a stream of bytes.

What a line did to a message is found by its checksum, so that noise convicts no vehicle; what its
sender did to it is up to the message's own decoder.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from enum import IntEnum, unique

from avsec_gym.errors import DataError

MOST_BYTES = 4 * 2**20
"""Most bytes of a packet's content: more than the longest message has."""
_MAGIC = b"AP"
_HEADER = struct.Struct("<2sBBIII")


@unique
class PacketStep(IntEnum):
    """What a packet is in the course of an instant."""

    WELCOME = 0
    """The vehicle's number, and how many are expected: from the base station, when it joins."""
    PROPOSALS = 1
    REGIONS = 2
    CLAIMS = 3
    """A vehicle's to the base station, then all vehicles' to all others."""
    WITNESS = 4
    """The base station asks for counts, since all claims are out."""
    COUNTS = 5


@dataclass(frozen=True)
class Packet:
    """A message on its way.

    Args:
        step: The step of the exchange that the packet belongs to.
        instant: Number of the instant.
        about: Number of the vehicle whose claims it holds or counts; 0 where there is none.
        content: The message.
    """

    step: PacketStep
    instant: int
    content: bytes
    about: int = 0

    def to_bytes(self) -> bytes:
        """The packet as it is sent.

        Raises:
            DataError: The content is longer than `MOST_BYTES`.
        """
        if len(self.content) > MOST_BYTES:
            raise DataError(f"a packet has at most {MOST_BYTES} bytes, not {len(self.content)}")
        size, check = len(self.content), zlib.crc32(self.content)
        return _HEADER.pack(_MAGIC, self.step, self.about, self.instant, size, check) + self.content


class PacketStream:
    """Cuts a stream of bytes into packets, and drops those whose checksum is wrong."""

    def __init__(self) -> None:
        self._rest = bytearray()
        self.damaged = 0

    def feed(self, received: bytes) -> list[Packet]:
        """The packets that are complete now.

        Args:
            received: What came in since the last call.

        Raises:
            DataError: Something else than a packet begins: nothing that follows can be read.
        """
        self._rest += received
        packets = []
        while len(self._rest) >= _HEADER.size:
            magic, step, about, instant, size, check = _HEADER.unpack_from(self._rest)
            if magic != _MAGIC or size > MOST_BYTES:
                raise DataError("This is no packet of connected vehicles.")
            end = _HEADER.size + size
            if len(self._rest) < end:
                break
            content = bytes(self._rest[_HEADER.size : end])
            del self._rest[:end]
            if zlib.crc32(content) == check and step in PacketStep.__members__.values():
                packets.append(Packet(PacketStep(step), instant, content, about))
            else:
                self.damaged += 1
        return packets
