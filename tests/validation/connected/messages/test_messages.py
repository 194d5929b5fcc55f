"""Messages: what comes out is what went in, and nothing else comes in."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from avsec_gym.errors import DataError
from avsec_gym.geometry import wrap_angle
from avsec_gym.validation.connected.messages.crop_message import CropMessage
from avsec_gym.validation.connected.messages.message_bytes import HeaderKind, header
from avsec_gym.validation.connected.messages.region_message import RegionMessage
from avsec_gym.validation.connected.regions import Regions

_SEEDS = st.integers(0, 2**32 - 1)


def _regions(random: np.random.Generator, count: int) -> Regions:
    return Regions(
        random.uniform(-300, 300, (count, 3)),
        random.uniform(0.2, 20, (count, 3)),
        random.uniform(-4, 4, count),
    )


def _region_message(seed: int, count: int) -> RegionMessage:
    random = np.random.default_rng(seed)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=random).as_matrix()
    pose[:3, 3] = random.uniform(-1e6, 1e6, 3)
    return RegionMessage(int(random.integers(65536)), pose, _regions(random, count))


@settings(deadline=None)
@given(_SEEDS, st.integers(0, 40))
def test_regions_come_back_to_the_stated_precision(seed: int, count: int) -> None:
    message = _region_message(seed, count)
    content = message.to_bytes()
    back = RegionMessage.from_bytes(content)
    assert len(content) == message.nbytes
    assert back.sender == message.sender
    assert back.regions.centre == pytest.approx(message.regions.centre, abs=0.00501)
    assert back.regions.size == pytest.approx(message.regions.size, abs=0.00501)
    turned = wrap_angle(back.regions.heading - message.regions.heading)
    assert np.abs(turned).max(initial=0) <= 5e-5
    assert back.pose[:3, 3] == pytest.approx(message.pose[:3, 3], abs=0.000501)
    assert back.pose[:3, :3] == pytest.approx(message.pose[:3, :3], abs=1e-6)
    # What was rounded once is not rounded again.
    assert RegionMessage.from_bytes(back.to_bytes()).regions.centre.tolist() == (
        back.regions.centre.tolist()
    )


@settings(deadline=None)
@given(_SEEDS, st.lists(st.integers(0, 60), max_size=6))
def test_crops_come_back_to_the_stated_precision(seed: int, counts: list[int]) -> None:
    random = np.random.default_rng(seed)
    message = CropMessage(3, tuple(random.uniform(-20, 20, (count, 3)) for count in counts))
    content = message.to_bytes()
    back = CropMessage.from_bytes(content)
    assert len(content) == message.nbytes
    assert [len(crop) for crop in back.crops] == counts
    for crop, original in zip(back.crops, message.crops, strict=True):
        assert crop == pytest.approx(original, abs=0.00501)


@settings(deadline=None)
@given(st.binary(max_size=200), st.sampled_from(list(HeaderKind)), st.booleans())
def test_garbage_is_refused_or_is_a_message(tail: bytes, kind: HeaderKind, begun: bool) -> None:
    content = header(kind, 1, 2) + tail if begun else tail
    for message in (RegionMessage, CropMessage):
        try:
            read = message.from_bytes(content)
        except DataError:
            continue
        assert read.nbytes == len(content)


@settings(deadline=None)
@given(_SEEDS, st.integers(0, 400), st.integers(1, 255))
def test_a_changed_byte_is_refused_or_changes_numbers_only(
    seed: int, place: int, change: int
) -> None:
    content = bytearray(_region_message(seed, 20).to_bytes())
    content[place % len(content)] ^= change
    try:
        back = RegionMessage.from_bytes(bytes(content))
    except DataError:
        return
    assert len(back.regions) == 20
    assert np.isfinite(back.pose).all()


@pytest.mark.parametrize("place", range(4))
def test_each_byte_of_the_beginning_is_looked_at(place: int) -> None:
    """Two of the format's name, its version, the kind: one wrong is enough."""
    content = bytearray(_region_message(0, 3).to_bytes())
    content[place] ^= 1
    with pytest.raises(DataError, match="does not begin as one of regions"):
        RegionMessage.from_bytes(bytes(content))


@pytest.mark.parametrize("kind", list(HeaderKind))
def test_a_thousand_million_of_anything_is_refused_by_its_header(kind: HeaderKind) -> None:
    message = {HeaderKind.REGIONS: RegionMessage, HeaderKind.CROPS: CropMessage}[kind]
    with pytest.raises(DataError, match="promises 1000000000"):
        message.from_bytes(header(kind, 0, 10**9) + bytes(100))


def test_crops_that_promise_too_many_points_are_refused() -> None:
    content = header(HeaderKind.CROPS, 0, 2) + np.array([4e9, 4e9], "<u4").tobytes()
    with pytest.raises(DataError, match="points"):
        CropMessage.from_bytes(content)


def test_what_is_too_far_away_is_not_sent() -> None:
    far = Regions(np.array([[400.0, 0, 0]]), np.ones((1, 3)), np.zeros(1))
    with pytest.raises(DataError):
        RegionMessage(0, np.eye(4), far).to_bytes()
    with pytest.raises(DataError):
        CropMessage(0, (np.array([[np.nan, 0, 0]]),)).to_bytes()
