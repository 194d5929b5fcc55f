"""`StationPort`: the base station's end of all connections, which no vehicle can hold up."""

from __future__ import annotations

import selectors
import socket
import time
from collections import Counter
from collections.abc import Callable, Collection
from types import TracebackType
from typing import Self, TypeVar

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.transport.packets import Packet, PacketStep, PacketStream

_PATIENCE = 0.5
"""Seconds that a vehicle has for taking what it is sent, before it is left out for good."""
_CHUNK = 1 << 16
_MOST_VEHICLES = 256
_MOST_EARLY = 8
"""Packets of later steps that are kept of a vehicle; one that keeps the order sends one or two."""

Message = TypeVar("Message")


class StationPort:
    """Connections to vehicles on this machine; the number of a vehicle is that of its connection.

    The sender that a message names is not believed. `tally` counts what was left out:
    ``late`` (of an earlier instant or step), ``doubled``, ``malformed`` (by checksum, or by
    decoder), ``too early`` (more of later steps than are kept), ``broken off`` (connections
    without packets any more).

    Args:
        vehicles: How many vehicles are expected, 1 to 256.

    Raises:
        ConfigurationError: Another number of vehicles.
    """

    def __init__(self, vehicles: int) -> None:
        if not 1 <= vehicles <= _MOST_VEHICLES:
            raise ConfigurationError(f"there are 1 to {_MOST_VEHICLES} vehicles, got {vehicles}")
        self.vehicles = vehicles
        self.tally: Counter[str] = Counter()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._connections: dict[int, socket.socket] = {}
        self._streams: dict[int, PacketStream] = {}
        self._early: dict[int, list[Packet]] = {}

    @property
    def number(self) -> int:
        """The number of the port that vehicles connect to."""
        return int(self._listener.getsockname()[1])

    def join(self, seconds: float) -> int:
        """Let vehicles connect, until all have or the time is over.

        Returns:
            How many have.
        """
        end = time.monotonic() + seconds
        while len(self._streams) < self.vehicles and (left := end - time.monotonic()) > 0:
            self._listener.settimeout(left)
            try:
                connection, _ = self._listener.accept()
            except TimeoutError:
                break
            number = len(self._streams)
            welcome = self.vehicles.to_bytes(2, "little")
            connection.settimeout(_PATIENCE)
            self._connections[number], self._streams[number] = connection, PacketStream()
            self._early[number] = []
            self._send(number, Packet(PacketStep.WELCOME, 0, welcome, number))
        return len(self._streams)

    def broadcast(self, packet: Packet) -> None:
        """Send a packet to all vehicles; one that does not take it is left out from now on."""
        for number in list(self._connections):
            self._send(number, packet)

    def gather(
        self,
        step: PacketStep,
        instant: int,
        decode: Callable[[int, bytes], Message],
        seconds: float,
        subjects: Collection[int] | None = None,
    ) -> dict[tuple[int, int], Message]:
        """What vehicles send at a step, until all have sent all or the time is over.

        Args:
            step: The step.
            instant: The number of the instant.
            decode: Function that makes a message of the sender's number and bytes, or refuses them
                with a DataError.
            seconds: How long is waited.
            subjects: The vehicles about each of which every other one sends a message; None: each
                sends one message, about none.

        Returns:
            The first sound message of each vehicle about each subject, by both numbers.
        """
        # What is expected: a message of each connected vehicle about each subject but itself.
        found: dict[tuple[int, int], Message] = {}
        answered: set[tuple[int, int]] = set()
        expected = {
            (number, about)
            for number in self._connections
            for about in ([0] if subjects is None else subjects)
            if subjects is None or number != about
        }

        def take(number: int, packet: Packet) -> None:
            # The first answer counts, even a malformed one.
            place = (number, packet.about)
            if (packet.instant, packet.step) != (instant, step):
                self._put_aside(number, packet, (instant, step))
            elif place in answered or place not in expected:
                self.tally["doubled"] += 1
            else:
                answered.add(place)
                try:
                    found[place] = decode(number, packet.content)
                except DataError:
                    self.tally["malformed"] += 1

        # First what came too early, then what comes.
        for number in self._connections:
            early, self._early[number] = self._early[number], []
            for packet in early:
                take(number, packet)
        # Until all have answered, the time is over, or those that are left have hung up.
        end = time.monotonic() + seconds
        with selectors.DefaultSelector() as selector:
            for number, connection in self._connections.items():
                selector.register(connection, selectors.EVENT_READ, number)
            while expected - answered and (left := end - time.monotonic()) > 0:
                for key, _ in selector.select(left):
                    packets = self._received(key.data)
                    if packets is None:
                        selector.unregister(key.fileobj)
                        expected = {each for each in expected if each[0] != key.data}
                        self._leave_out(key.data)
                    for packet in packets or ():
                        take(key.data, packet)
        return found

    def close(self) -> None:
        """End all connections."""
        for number in list(self._connections):
            self._connections.pop(number).close()
        self._listener.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _received(self, number: int) -> list[Packet] | None:
        """The packets that are there; None where none will come any more."""
        stream = self._streams[number]
        damaged = stream.damaged
        try:
            content = self._connections[number].recv(_CHUNK)
            return stream.feed(content) if content else None
        except (OSError, DataError):
            return None
        finally:
            if stream.damaged > damaged:
                self.tally["malformed"] += stream.damaged - damaged

    def _put_aside(self, number: int, packet: Packet, now: tuple[int, PacketStep]) -> None:
        """Keep a packet of a later step, a few of each vehicle; count one of an earlier step."""
        if (packet.instant, packet.step) < now:
            self.tally["late"] += 1
        elif len(self._early[number]) < _MOST_EARLY:
            self._early[number].append(packet)
        else:
            self.tally["too early"] += 1

    def _send(self, number: int, packet: Packet) -> None:
        try:
            self._connections[number].sendall(packet.to_bytes())
        except OSError:
            self._leave_out(number)

    def _leave_out(self, number: int) -> None:
        self.tally["broken off"] += 1
        self._connections.pop(number).close()
