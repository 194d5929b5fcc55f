"""`SentMessages`: all of an instant, with their bytes, what was refused, and the time of steps.

In one process nothing is sent anywhere, but every message becomes bytes and is read back from
them, so that what is counted is what would be sent, and what is decided is decided of what would
arrive.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from typing import Any, TypeVar

from avsec_gym.errors import DataError

_Message = TypeVar("_Message")


class MessageKind(StrEnum):
    """What a vehicle sends to the base station."""

    PROPOSALS = "proposals"
    CLAIMS = "claims"
    COUNTS = "counts"
    """How its rays support the claims of all others, a message for each of them."""
    CROPS = "crops"


Wire = Callable[[MessageKind, int, bytes], list[bytes]]
"""What arrives of a message: its kind, the number of its sender, its bytes. A message that is lost
arrives as an empty list, one that is doubled twice, that of a liar as something else."""


def sound_wire(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
    """Every message arrives as it was sent."""
    return [content]


class SentMessages:
    """The messages of an instant.

    Args:
        vehicles: Number of vehicles.
        wire: What arrives of each message.
        most_bytes: The most bytes that one vehicle sends; what exceeds them is refused. None: all
            is taken.
    """

    def __init__(
        self, vehicles: int, wire: Wire = sound_wire, most_bytes: int | None = None
    ) -> None:
        self.sent: list[Counter[str]] = [Counter() for _ in range(vehicles)]
        self.from_station: Counter[str] = Counter()
        self.refused: list[str] = []
        self.seconds: dict[str, float] = {}
        self._wire, self._most = wire, most_bytes

    def room(self, sender: int) -> int | None:
        """The bytes that a vehicle may still send, None without a limit."""
        return None if self._most is None else self._most - self.sent[sender].total()

    def send(
        self, kind: MessageKind, sender: int, content: bytes, read: Callable[[bytes], _Message]
    ) -> list[_Message]:
        """A message on its way to the base station.

        Args:
            kind: The kind of the message.
            sender: Number of the vehicle, which is that of its connection.
            content: The message's bytes.
            read: Function that reads a message, or raises `DataError`.

        Returns:
            What the base station reads of it.
        """
        taken = []
        # A line that doubles a message is not its sender's fault.
        for arrived in dict.fromkeys(self._wire(kind, sender, content)):
            room = self.room(sender)
            self.sent[sender][kind] += len(arrived)
            if room is not None and len(arrived) > room:
                self.refused.append(f"{kind} of {sender}: more than {self._most} bytes in all")
                continue
            try:
                taken.append(read(arrived))
            except DataError as error:
                self.refused.append(f"{kind} of {sender}: {error.problem}")
        return taken

    def broadcast(self, kind: str, content: bytes) -> None:
        """Count a message of the base station to all vehicles."""
        self.from_station[kind] += len(content)

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Measure the time of a step, which adds up over vehicles."""
        begin = time.perf_counter()
        try:
            yield
        finally:
            passed = time.perf_counter() - begin
            self.seconds[name] = self.seconds.get(name, 0.0) + passed

    def to_json(self) -> dict[str, Any]:
        """Bytes, refused messages and seconds."""
        return {
            "bytes": [{str(kind): size for kind, size in each.items()} for each in self.sent],
            "bytes_from_station": dict(self.from_station),
            "refused": self.refused,
            "seconds": {name: round(value, 6) for name, value in self.seconds.items()},
        }
