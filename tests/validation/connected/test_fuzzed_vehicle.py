"""A vehicle that sends garbage, NaN, 10^9 claims or nothing changes nothing about the others."""

from __future__ import annotations

import struct
from collections.abc import Callable
from itertools import product

import numpy as np
import pytest

from avsec_gym.validation.connected import ray_exchange
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.rays.observer import Observer, observe
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.traffic import MessageKind
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import Box, pose_at, scan_of

_CAR, _GHOST = (14.0, 3.0, 0.1), (15.0, -4.0, -0.2)
_POSES = (
    pose_at(0, 0, 0),
    pose_at(30, 2, np.pi),
    pose_at(14, -14, np.pi / 2),
    pose_at(22, 12, -2.0),
)
_VICTIM, _BROKEN = 1, 3
_KINDS = (MessageKind.PROPOSALS, MessageKind.CLAIMS, MessageKind.COUNTS)
_PROMISES = {MessageKind.PROPOSALS: ("<I", 6, 10**9)}
"""Where the number of things stands that a message promises, and the largest that it can hold."""
_Random = np.random.Generator
_Damage = Callable[[MessageKind, bytes, _Random], bytes]


def _nothing(kind: MessageKind, content: bytes, random: _Random) -> bytes:
    return b""


def _garbage(kind: MessageKind, content: bytes, random: _Random) -> bytes:
    return random.bytes(int(random.integers(1, 4000)))


def _garbage_behind_the_header(kind: MessageKind, content: bytes, random: _Random) -> bytes:
    kept = int(random.integers(3, 40))
    return content[:kept] + random.bytes(max(len(content) - kept, 0))


def _nan(kind: MessageKind, content: bytes, random: _Random) -> bytes:
    # Of proposals, the pose begins after 10 bytes, its rotation after 22.
    at = 22 if kind is MessageKind.PROPOSALS else 3
    many = (len(content) - at) // 4 if random.integers(2) else 3
    return content[:at] + many * struct.pack("<f", np.nan) + content[at + 4 * many :]


def _promises(kind: MessageKind, content: bytes, random: _Random) -> bytes:
    form, at, number = _PROMISES.get(kind, ("<H", 1, 65535))
    return content[:at] + struct.pack(form, number) + content[at + struct.calcsize(form) :]


def _cut(kind: MessageKind, content: bytes, random: _Random) -> bytes:
    return content[: int(random.integers(0, len(content)))]


def _flipped(kind: MessageKind, content: bytes, random: _Random) -> bytes:
    raw = np.frombuffer(content, np.uint8).copy()
    chosen = random.integers(0, len(raw), int(random.integers(1, 9)))
    raw[chosen] ^= (1 << random.integers(0, 8, len(chosen))).astype(np.uint8)
    return raw.tobytes()


def _endless(kind: MessageKind, content: bytes, random: _Random) -> bytes:
    return content * 1000


@pytest.fixture(scope="module")
def scans() -> dict[str, list[VehicleScan]]:
    """Four vehicles that see a car; without an attack, and with a ghost in the scan of one."""
    clean = [scan_of(pose, _CAR) for pose in _POSES]
    ghost = clean.copy()
    ghost[_VICTIM] = scan_of(_POSES[_VICTIM], _CAR, _GHOST)
    return {"clean": clean, "ghost": ghost}


@pytest.fixture(scope="module")
def validator() -> ConnectedValidator:
    """What it proposes of a scan does not change while messages are damaged."""
    proposed: dict[int, tuple[np.ndarray, Regions]] = {}

    def propose(points: np.ndarray) -> Regions:
        if id(points) not in proposed:
            proposed[id(points)] = points, ClusterProposer()(points)
        return proposed[id(points)][1]

    return ConnectedValidator(proposer=propose)


@pytest.fixture(autouse=True)
def _rays_are_sorted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    observers: dict[VehicleScan, Observer] = {}

    def once(scan: VehicleScan) -> Observer:
        if scan not in observers:
            observers[scan] = observe(scan)
        return observers[scan]

    monkeypatch.setattr(ray_exchange, "observe", once)


def _near(result: ConnectedResult, place: Box) -> int:
    away = np.linalg.norm(result.regions.centre[:, :2] - place[:2], axis=1)
    assert away.min() < 1.5
    return int(away.argmin())


@pytest.mark.parametrize(
    "damage",
    [
        _nothing,
        _garbage,
        _garbage_behind_the_header,
        _nan,
        _promises,
        _cut,
        _flipped,
        _endless,
    ],
)
def test_a_broken_vehicle_changes_nothing_about_others(
    damage: _Damage, scans: dict[str, list[VehicleScan]], validator: ConnectedValidator
) -> None:
    refused = 0
    for broken, state, seed in product(_KINDS, scans, range(3)):
        random = np.random.default_rng(seed)
        sent = 0

        def damaged(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
            nonlocal sent
            if (kind, sender) != (broken, _BROKEN):  # noqa: B023
                return [content]
            sent += 1
            return [damage(kind, content, random)]  # noqa: B023

        def lost(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
            return [] if (kind, sender) == (broken, _BROKEN) else [content]  # noqa: B023

        result = validator.validate(scans[state], wire=damaged)
        # Who is honest is not named, whatever was read of it.
        assert not set(result.accused) & ({0, 1, 2} - ({_VICTIM} if state == "ghost" else set()))
        if state == "ghost":
            assert result.named[_near(result, _GHOST)] == _VICTIM
        if len(result.traffic.refused) < sent:
            continue
        # What cannot be read is as if it had never been sent.
        refused += 1
        without = validator.validate(scans[state], wire=lost)
        np.testing.assert_array_equal(result.named, without.named)
        assert result.counts is not None
        assert without.counts is not None
        others = np.ix_(range(len(result.regions)), range(_BROKEN), range(_BROKEN))
        np.testing.assert_array_equal(result.counts[others], without.counts[others])
    assert refused > 0


@pytest.mark.parametrize("state", ["clean", "ghost"])
def test_one_that_sends_nothing_is_as_if_it_were_not_there(
    state: str, scans: dict[str, list[VehicleScan]], validator: ConnectedValidator
) -> None:
    def lost(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
        return [] if sender == _BROKEN else [content]

    silent = validator.validate(scans[state], wire=lost)
    alone = validator.validate(scans[state][:_BROKEN])
    np.testing.assert_array_equal(silent.regions.centre, alone.regions.centre)
    np.testing.assert_array_equal(silent.named, alone.named)
    assert silent.counts is not None
    others = np.ix_(range(len(silent.regions)), range(_BROKEN), range(_BROKEN))
    np.testing.assert_array_equal(silent.counts[others], alone.counts)
    if state == "ghost":
        assert silent.named[_near(silent, _GHOST)] == _VICTIM
