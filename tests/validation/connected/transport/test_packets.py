"""Packets come out of any stream that they went into, and damaged ones do not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.transport.packets import (
    MOST_BYTES,
    Packet,
    PacketStep,
    PacketStream,
)

_PACKETS = st.builds(
    Packet,
    st.sampled_from(PacketStep),
    st.integers(0, 2**32 - 1),
    st.binary(max_size=60),
    st.integers(0, 255),
)


@given(st.lists(_PACKETS, max_size=5), st.integers(1, 30))
def test_packets_come_out_however_the_stream_is_cut(packets: list[Packet], size: int) -> None:
    content = b"".join(packet.to_bytes() for packet in packets)
    stream, found = PacketStream(), []
    for start in range(0, len(content), size):
        found += stream.feed(content[start : start + size])
    assert found == packets
    assert stream.damaged == 0


@given(_PACKETS, st.integers(0, 59), st.integers(1, 255))
def test_a_changed_message_is_dropped_and_the_next_one_read(
    packet: Packet, place: int, change: int
) -> None:
    content = bytearray(packet.to_bytes())
    if not packet.content:
        return
    content[len(content) - 1 - place % len(packet.content)] ^= change
    stream = PacketStream()
    assert stream.feed(bytes(content) + packet.to_bytes()) == [packet]
    assert stream.damaged == 1


@given(st.binary(min_size=16, max_size=100))
def test_garbage_ends_the_stream_or_waits(content: bytes) -> None:
    stream = PacketStream()
    if not content.startswith(b"AP"):
        with pytest.raises(DataError):
            stream.feed(content)


def test_what_is_too_long_is_neither_sent_nor_awaited() -> None:
    with pytest.raises(DataError):
        Packet(PacketStep.CLAIMS, 0, bytes(MOST_BYTES + 1)).to_bytes()
    sound = bytearray(Packet(PacketStep.CLAIMS, 0, b"abc").to_bytes())
    sound[8:12] = (10**9).to_bytes(4, "little")
    with pytest.raises(DataError):
        PacketStream().feed(bytes(sound))
