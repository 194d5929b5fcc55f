"""`VehiclePort`: a vehicle's end of its connection, with a line that can be as bad as wanted."""

from __future__ import annotations

import socket
import time
from collections import deque
from dataclasses import dataclass

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.transport.packets import Packet, PacketStep, PacketStream


@dataclass(frozen=True)
class Faults:
    """How often a packet suffers on its way, each from 0 to 1.

    Args:
        lost: The probability that a packet never arrives.
        late: The probability that it arrives together with the vehicle's next one.
        doubled: The probability that it arrives twice.
        malformed: A byte of the message is another, and the checksum fits: as the sender's fault.

    Raises:
        ConfigurationError: A share that is none.
    """

    lost: float = 0.0
    late: float = 0.0
    doubled: float = 0.0
    malformed: float = 0.0

    def __post_init__(self) -> None:
        if not all(0 <= each <= 1 for each in vars(self).values()):
            raise ConfigurationError(f"shares of faults are from 0 to 1, got {self}")


class VehiclePort:
    """A connection to the base station.

    Args:
        port: The number of its port on this machine.
        faults: How bad the line is.
        seed: The seed that decides which packets suffer.
        seconds: How long it waits for being welcomed.

    Raises:
        DataError: There is no base station, or it does not answer.
    """

    def __init__(
        self, port: int, faults: Faults = Faults(), seed: int = 0, seconds: float = 30.0
    ) -> None:
        try:
            self._socket = socket.create_connection(("127.0.0.1", port), seconds)
        except OSError as error:
            raise DataError(
                f"No base station listens at port {port} ({error}).",
                remedy="Start it first, and name the port that it states.",
            ) from error
        self._stream, self._waiting = PacketStream(), deque[Packet]()
        self._faults, self._random = faults, np.random.default_rng(seed)
        self._held_back = b""
        welcome = self.receive(seconds)
        if welcome is None or welcome.step != PacketStep.WELCOME:
            raise DataError("The base station does not answer.", remedy="Start it anew.")
        self.number = welcome.about
        self.vehicles = int.from_bytes(welcome.content, "little")
        """How many vehicles the base station expects, this one among them."""

    def send(self, packet: Packet) -> None:
        """Send a packet, over a bad line; one that has broken shows when something is awaited."""
        content = packet.to_bytes()
        if self._happens(self._faults.malformed) and packet.content:
            changed = bytearray(packet.content)
            changed[self._random.integers(len(changed))] ^= int(self._random.integers(1, 256))
            content = Packet(packet.step, packet.instant, bytes(changed), packet.about).to_bytes()
        if self._happens(self._faults.doubled):
            content *= 2
        if self._happens(self._faults.lost):
            content = b""
        if self._happens(self._faults.late):
            self._held_back += content
            return
        self.send_bytes(self._held_back + content)
        self._held_back = b""

    def send_bytes(self, content: bytes) -> None:
        """Send anything, be it a packet or not."""
        try:
            self._socket.sendall(content)
        except OSError:
            self._socket.close()

    def receive(self, seconds: float) -> Packet | None:
        """The next packet; None if none comes in this time, or none will any more."""
        end = time.monotonic() + seconds
        while not self._waiting and (left := end - time.monotonic()) > 0:
            try:
                self._socket.settimeout(left)
                content = self._socket.recv(1 << 16)
                self._waiting.extend(self._stream.feed(content))
            except (OSError, DataError):
                return None
            if not content:
                return None
        return self._waiting.popleft() if self._waiting else None

    def close(self) -> None:
        """End the connection."""
        self._socket.close()

    def _happens(self, share: float) -> bool:
        return bool(self._random.random() < share)
