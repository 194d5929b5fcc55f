"""Messages of claims and testimonies: exact, small, and read with distrust."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.rays.claim_message import (
    MOST_BYTES,
    TIME_STEP,
    VELOCITY_STEP,
    decode_claims,
    encode_claims,
)
from avsec_gym.validation.connected.rays.claims import MARGIN, SEARCHED, Claims, grid_shapes
from avsec_gym.validation.connected.rays.witness_counts import (
    WitnessCounts,
    decode_counts,
    encode_counts,
)
from avsec_gym.validation.connected.regions import Regions

_SIZES = np.array([[4.0, 2.0, 1.5], [12.0, 3.0, 4.0], [0.6, 0.6, 1.8], [4.5, 1.8, 1.6]])
_REGIONS = Regions(np.zeros((4, 3)), _SIZES, np.zeros(4))
_ROOM = grid_shapes(_REGIONS.grown(MARGIN, MARGIN).size).prod(axis=1)


@st.composite
def _claims(draw: st.DrawFn) -> Claims:
    regions = sorted(draw(st.sets(st.integers(0, 3))))
    voxels = [
        sorted(draw(st.sets(st.integers(0, int(_ROOM[i]) - 1), min_size=1, max_size=60)))
        for i in regions
    ]
    speed = st.floats(-60, 60)
    velocity = [[draw(speed), draw(speed)] for _ in regions]
    return Claims(
        np.array(regions, np.int64),
        np.array(velocity, float).reshape(-1, 2),
        np.array([len(each) for each in voxels], np.int64),
        np.concatenate([np.zeros(0, np.int64), *[np.array(each, np.int64) for each in voxels]]),
        np.array([draw(st.floats(-65.0, 65.0)) for _ in regions]),
    )


@given(_claims())
def test_claims_come_back(claims: Claims) -> None:
    message = encode_claims(claims)
    back = decode_claims(message, _REGIONS, at_intervals=True)
    assert np.array_equal(back.region, claims.region)
    assert np.array_equal(back.count, claims.count)
    assert np.array_equal(back.voxel, claims.voxel)
    assert np.abs(back.velocity - claims.velocity).max(initial=0) <= VELOCITY_STEP / 2 + 1e-9
    assert np.abs(back.time - claims.time).max(initial=0) <= TIME_STEP / 2 + 1e-9
    assert encode_claims(back) == message


def test_what_is_claimed_of_another_time_than_the_instants_is_refused() -> None:
    one = np.ones(1, np.int64)
    for time in (SEARCHED, -SEARCHED):
        at_once = encode_claims(Claims(one, np.zeros((1, 2)), one, one, np.array([time])))
        assert decode_claims(at_once, _REGIONS).time == pytest.approx([time], abs=TIME_STEP)
        later = encode_claims(Claims(one, np.zeros((1, 2)), one, one, np.array([2 * time])))
        with pytest.raises(DataError, match=r"0\.500 s beside the instant"):
            decode_claims(later, _REGIONS)
        assert decode_claims(later, _REGIONS, at_intervals=True).time == pytest.approx([2 * time])


@settings(max_examples=300)
@given(st.binary(max_size=200), st.booleans())
def test_noise_is_refused_or_holds_claims_that_fit(noise: bytes, begins_right: bool) -> None:
    message = b"\x03" + noise if begins_right else noise
    try:
        claims = decode_claims(message, _REGIONS)
    except DataError:
        return
    assert (claims.voxel < np.repeat(_ROOM[claims.region], claims.count)).all()
    assert encode_claims(claims) in (message, encode_claims(claims))


@given(_claims(), st.data())
def test_a_damaged_message_is_refused_or_still_fits(claims: Claims, data: st.DataObject) -> None:
    message = bytearray(encode_claims(claims))
    place = data.draw(st.integers(0, len(message) - 1))
    message[place] ^= data.draw(st.integers(1, 255))
    try:
        back = decode_claims(bytes(message), _REGIONS)
    except DataError:
        return
    assert (back.region < 4).all()
    assert (back.voxel < np.repeat(_ROOM[back.region], back.count)).all()


def _message(*numbers: int) -> bytes:
    return bytes(numbers)


@pytest.mark.parametrize(
    "message",
    [
        pytest.param(b"", id="nothing"),
        pytest.param(_message(1, 0, 0), id="another format"),
        pytest.param(_message(3, 255, 255), id="65,535 claims"),
        pytest.param(_message(3, 0, 0, 5), id="something after the end"),
        pytest.param(_message(3, 1, 0, 9, 0, 0, 0, 0, 0, 1, 0, 0, 7), id="a region that is none"),
        pytest.param(_message(3, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0), id="a claim of nothing"),
        pytest.param(_message(3, 1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 7), id="a voxel cut off"),
        pytest.param(_message(3, 1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 7, 0), id="a voxel twice"),
        pytest.param(_message(3, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 255, 255, 127), id="outside"),
        pytest.param(_message(3, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 255, 255, 255, 1), id="4 bytes"),
        pytest.param(_message(3, 1, 0, 0, 0, 0, 0, 0, 0, 255, 0, 0) + b"\x01" * 255, id="too many"),
        pytest.param(b"\x03" + b"\x00" * MOST_BYTES, id="too long"),
    ],
)
def test_what_is_no_message_of_claims_is_refused(message: bytes) -> None:
    with pytest.raises(DataError, match="no message of claims"):
        decode_claims(message, _REGIONS)


def test_a_voxel_costs_about_a_byte() -> None:
    claims = Claims(np.array([0]), np.zeros((1, 2)), np.array([100]), np.arange(0, 1000, 10))
    assert len(encode_claims(claims)) == 3 + 9 + 100


def test_testimonies_come_back_without_what_says_nothing() -> None:
    testimony = WitnessCounts(np.array([0, 2, 3]), np.array([[3, 0, 7], [0, 0, 0], [0, 120, 0]]))
    message = encode_counts(testimony)
    back = decode_counts(message, _REGIONS)
    assert len(message) == 3 + 2 * 5
    assert back.region.tolist() == [0, 3]
    assert back.counts.tolist() == [[3, 0, 7], [0, 120, 0]]


@given(st.binary(max_size=100))
def test_noise_is_no_testimony_or_one_that_fits(noise: bytes) -> None:
    for message in (noise, b"\x01" + noise):
        try:
            testimony = decode_counts(message, _REGIONS)
        except DataError:
            continue
        assert (testimony.region < 4).all()
        assert (testimony.counts.sum(axis=1) <= 120).all()


@pytest.mark.parametrize("time", [65.6, -70.0])
def test_a_time_that_no_message_holds_is_refused(time: float) -> None:
    one = np.array([1])
    claims = Claims(np.array([0]), np.zeros((1, 2)), one, np.array([5]), np.array([time]))
    with pytest.raises(DataError, match="beside the instant"):
        encode_claims(claims)
