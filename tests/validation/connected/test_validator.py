"""Instants of connected vehicles, whole: who is named, what is sent, and what a liar can do."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.budget import MessageBudget
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.messages.region_message import RegionMessage
from avsec_gym.validation.connected.rays.claim_message import decode_claims, encode_claims
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.traffic import MessageKind
from avsec_gym.validation.connected.validator import ConnectedValidator, Method
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import Box, pose_at, scan_of

_CAR, _GHOST = (14.0, 3.0, 0.1), (15.0, -4.0, -0.2)
_POSES = (
    pose_at(0, 0, 0),
    pose_at(30, 2, np.pi),
    pose_at(14, -14, np.pi / 2),
    pose_at(22, 12, -2.0),
)
_VICTIM, _LIAR = 1, 3


@pytest.fixture(scope="module")
def scans_of() -> Callable[..., list[VehicleScan]]:
    """Scans of four vehicles, which see the car and what else each is given."""

    def scans(**more: tuple[Box, ...]) -> list[VehicleScan]:
        return [
            scan_of(pose, *more.get(f"v{number}", (_CAR,))) for number, pose in enumerate(_POSES)
        ]

    return scans


@pytest.fixture(scope="module")
def clean(scans_of: Callable[..., list[VehicleScan]]) -> list[VehicleScan]:
    """Without an attack."""
    return scans_of()


@pytest.fixture(scope="module")
def ghost(scans_of: Callable[..., list[VehicleScan]]) -> list[VehicleScan]:
    """A ghost in the scan of vehicle 1."""
    return scans_of(v1=(_CAR, _GHOST))


def _at(result: ConnectedResult, place: Box) -> int:
    """The region at a place."""
    away = np.linalg.norm(result.regions.centre[:, :2] - place[:2], axis=1)
    assert away.min() < 1.5
    return int(away.argmin())


@pytest.mark.parametrize("method", ["rays", "surfaces"])
def test_the_vehicle_with_a_ghost_is_named(method: Method, ghost: list[VehicleScan]) -> None:
    result = ConnectedValidator(method=method).validate(ghost, id="000007")
    assert result.accused == (_VICTIM,)
    first = result.accusations[0]
    assert (first.vehicle, first.kind, first.index) == (_VICTIM, "ghost", _at(result, _GHOST))
    assert result.named[_at(result, _CAR)] == NO_ATTACK
    assert json.loads(json.dumps(result.to_json()))["accused"] == [_VICTIM]


@pytest.mark.parametrize(("method", "victim"), [("rays", 1), ("surfaces", 1), ("surfaces", 3)])
def test_a_removed_car_names_the_vehicle_that_lacks_it(
    method: Method, victim: int, scans_of: Callable[..., list[VehicleScan]]
) -> None:
    result = ConnectedValidator(method=method).validate(scans_of(**{f"v{victim}": ()}))
    first = result.accusations[0]
    assert (result.accused, first.kind) == ((victim,), "removal")


@pytest.mark.parametrize("method", ["rays", "surfaces"])
def test_without_an_attack_no_region_alarms(method: Method, clean: list[VehicleScan]) -> None:
    result = ConnectedValidator(method=method).validate(clean)
    assert not result.alarm
    assert result.accused == ()
    assert result.decidable[_at(result, _CAR)]
    assert set(result.traffic.seconds) >= {"propose", "merge", "decide"}


def test_two_vehicles_contradict_each_other_and_none_is_named(ghost: list[VehicleScan]) -> None:
    result = ConnectedValidator().validate(ghost[:2])
    assert result.alarm
    assert result.accused == ()
    assert result.accusations[0].vehicle == CANNOT_TELL


def test_what_is_counted_is_what_is_sent(ghost: list[VehicleScan]) -> None:
    sent = np.zeros(4, int)

    def weighed(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
        sent[sender] += len(content)
        return [content]

    result = ConnectedValidator().validate(ghost, wire=weighed)
    assert result.bytes_of_vehicles == tuple(sent)
    assert 0 < max(result.bytes_of_vehicles) <= 4096


def test_a_small_budget_is_kept_and_still_names(ghost: list[VehicleScan]) -> None:
    result = ConnectedValidator(budget=MessageBudget(nbytes=256)).validate(ghost)
    assert max(result.bytes_of_vehicles) <= 256
    assert not result.traffic.refused
    assert result.accused == (_VICTIM,)


def test_lost_messages_are_as_a_vehicle_less(ghost: list[VehicleScan]) -> None:
    def line(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
        return [] if sender == _LIAR else [content]

    heard = ConnectedValidator().validate(ghost, wire=line)
    without = ConnectedValidator().validate(ghost[:3])
    assert heard.accused == without.accused == (_VICTIM,)
    np.testing.assert_array_equal(heard.named, without.named)


def test_doubled_messages_count_once(ghost: list[VehicleScan]) -> None:
    def line(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
        return [content, content]

    doubled, once = (
        ConnectedValidator().validate(ghost, wire=line),
        ConnectedValidator().validate(ghost),
    )
    np.testing.assert_array_equal(doubled.named, once.named)
    assert doubled.bytes_of_vehicles == once.bytes_of_vehicles


def test_the_first_of_several_claims_counts(ghost: list[VehicleScan]) -> None:
    """Who takes a claim back in a second message, the one of no ghost, is named as before."""
    seen = ConnectedValidator().validate(ghost)

    def line(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
        if (kind, sender) != (MessageKind.CLAIMS, _VICTIM):
            return [content]
        return [content, encode_claims(decode_claims(content, seen.regions)[:0])]

    twice = ConnectedValidator().validate(ghost, wire=line)
    assert not twice.traffic.refused
    np.testing.assert_array_equal(twice.counts, seen.counts)
    assert twice.accused == seen.accused == (_VICTIM,)


def _random(kind: MessageKind, content: bytes) -> bytes:
    return np.random.default_rng(len(content)).bytes(len(content))


def _longer(kind: MessageKind, content: bytes) -> bytes:
    return content + bytes(1_000_000)


def _nothing_in_it(kind: MessageKind, content: bytes) -> bytes:
    return b""


def _elsewhere(kind: MessageKind, content: bytes) -> bytes:
    """It claims to be where no other vehicle is."""
    if kind is not MessageKind.PROPOSALS:
        return content
    message = RegionMessage.from_bytes(content)
    pose = message.pose.copy()
    pose[:3, 3] += [5000.0, -5000.0, 0.0]
    return RegionMessage(message.sender, pose, message.regions).to_bytes()


def _in_the_name_of_another(kind: MessageKind, content: bytes) -> bytes:
    if kind is not MessageKind.PROPOSALS:
        return content
    message = RegionMessage.from_bytes(content)
    return RegionMessage(0, message.pose, message.regions).to_bytes()


def _everywhere(kind: MessageKind, content: bytes) -> bytes:
    """It proposes as many regions as a message holds."""
    if kind is not MessageKind.PROPOSALS:
        return content
    message = RegionMessage.from_bytes(content)
    random = np.random.default_rng(0)
    centre = np.c_[random.uniform(-60, 60, (1000, 2)), np.full(1000, -1.7)]
    regions = Regions(centre, np.tile([4.2, 1.8, 1.5], (1000, 1)), random.uniform(-3, 3, 1000))
    return RegionMessage(message.sender, message.pose, regions).to_bytes()


@pytest.mark.parametrize(
    "lie",
    [_random, _longer, _nothing_in_it, _elsewhere, _in_the_name_of_another, _everywhere],
)
@pytest.mark.parametrize("method", ["rays", "surfaces"])
def test_no_liar_convicts_an_honest_vehicle_nor_hides_the_victim(
    method: Method,
    lie: Callable[[MessageKind, bytes], bytes],
    ghost: list[VehicleScan],
    clean: list[VehicleScan],
) -> None:
    def line(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
        return [lie(kind, content) if sender == _LIAR else content]

    validator = ConnectedValidator(method=method)
    lied = validator.validate(ghost, wire=line)
    assert lied.named[_at(lied, _GHOST)] == _VICTIM
    honest = {0, 1, 2} - {_VICTIM}
    assert not honest & set(lied.accused)
    assert not {0, 1, 2} & set(validator.validate(clean, wire=line).accused)


def test_a_vehicle_that_is_not_heard_at_all_leaves_two_that_cannot_tell(
    ghost: list[VehicleScan],
) -> None:
    def silent(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
        return []

    result = ConnectedValidator().validate(ghost, wire=silent)
    assert len(result.regions) == 0
    assert not result.alarm
    assert result.decidable_share is None


def test_what_exceeds_the_budget_is_refused_and_said_so(clean: list[VehicleScan]) -> None:
    def line(kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
        return [content + bytes(5000)] if sender == 0 else [content]

    result = ConnectedValidator().validate(clean, wire=line)
    assert result.traffic.refused[0] == "proposals of 0: more than 4096 bytes in all"
    assert result.traffic.sent[0].total() > 4096


def test_a_vehicle_is_no_witness_of_what_it_stands_in(clean: list[VehicleScan]) -> None:
    merged_in: list[int] = []

    def here(points: np.ndarray) -> Regions:
        return Regions(np.array([[0.0, 0, -1.73]]), np.array([[4.0, 2, 1.5]]), np.zeros(1))

    result = ConnectedValidator(proposer=here).validate(clean)
    for vehicle, pose in enumerate(_POSES):
        region = int(np.linalg.norm(result.regions.centre - pose[:3, 3], axis=1).argmin())
        assert result.counts is not None
        assert not result.counts[region, :, vehicle].any()
        merged_in.append(region)
    assert len(set(merged_in)) == 4


def _taken(apart: float, poses: Sequence[np.ndarray], *boxes: tuple[Box, ...]) -> list[VehicleScan]:
    """Scans of three vehicles, so many seconds one after the other."""
    return [
        replace(scan_of(pose, *seen), time=apart * (number - 1), sweep=RollingSweep(period=0.0))
        for number, (pose, seen) in enumerate(zip(poses, boxes, strict=True))
    ]


@pytest.mark.parametrize("apart", [0.1, 0.2, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("speed", [6.0, 15.0])
@pytest.mark.parametrize("heading", [0.1, 1.6])
def test_no_honest_vehicle_is_named_beside_a_car_that_moves(
    apart: float, speed: float, heading: float
) -> None:
    x, y, _ = _GHOST
    way = speed * apart * np.array([-1.0, 0.0, 1.0])
    moving = [(x + by * np.cos(heading), y + by * np.sin(heading), heading) for by in way]
    scans = _taken(apart, _POSES[:3], *((_CAR, each) for each in moving))
    assert ConnectedValidator().validate(scans).accused == ()


def test_scans_half_a_second_apart_still_show_what_was_cut_out_of_the_middle_one() -> None:
    # One vehicle that drives on, as in the thesis (section 4.5).
    poses = [pose_at(0.6 * number, 0, 0) for number in range(3)]
    scans = _taken(0.5, poses, (_CAR,), (), (_CAR,))
    assert ConnectedValidator().validate(scans).accused == (1,)
    # Cut out of the first one, it may have come since.
    assert ConnectedValidator().validate(_taken(0.5, poses, (), (_CAR,), (_CAR,))).accused == ()


def test_a_roadside_lidar_bears_witness_of_what_stands_under_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    car = (3.0, 0.0, 0.0)
    poses = (pose_at(20, 5, np.pi), pose_at(0, 0, 0))
    scans = [scan_of(pose, car) for pose in poses]
    fixed = [scans[0], replace(scans[1], roadside=True)]
    # The scan keeps what it is when its motion is compensated, and when its points are others.
    moving = replace(fixed[1], sweep=RollingSweep(speed=1.0))
    assert moving.compensated().roadside
    assert moving.with_points(moving.points[:5]).roadside
    # The car is where a vehicle with this sensor would have its own body.
    as_vehicle, as_pole = (ConnectedValidator().validate(each) for each in (scans, fixed))
    for result, witnesses in ((as_vehicle, False), (as_pole, True)):
        assert result.counts is not None
        here = np.hypot(*(result.regions.centre[:, :2] - car[:2]).T) < 2.0
        assert here.any()
        assert bool(result.counts[here, 0, 1].any()) == witnesses


def test_bad_arguments_are_named(clean: list[VehicleScan]) -> None:
    with pytest.raises(ConfigurationError, match="methods are"):
        ConnectedValidator(method="lidar")  # type: ignore[arg-type]
    with pytest.raises(DataError, match="two or more"):
        ConnectedValidator().validate(clean[:1])
    with pytest.raises(ConfigurationError, match="256 bytes"):
        MessageBudget(nbytes=10)
    with pytest.raises(ConfigurationError, match="distances"):
        ConnectedConstants(theta=float("nan"))
