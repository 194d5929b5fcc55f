"""Instants over sockets: the same decision as without, whatever one vehicle does to its line."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.budget import MessageBudget
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.rays.claims import claim
from avsec_gym.validation.connected.rays.observer import observe
from avsec_gym.validation.connected.rays.witness import WitnessMargins
from avsec_gym.validation.connected.rays.witness_counts import count_rays
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.transport.exchange import (
    InstantOutcome,
    judge_instant,
    take_part,
)
from avsec_gym.validation.connected.transport.packets import Packet, PacketStep
from avsec_gym.validation.connected.transport.station_port import StationPort
from avsec_gym.validation.connected.transport.vehicle_port import Faults, VehiclePort
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import Box, pose_at, scan_of

_CAR, _GHOST = (14.0, 3.0, 0.1), (15.0, -4.0, -0.2)
_VICTIM = 1
_POSES = (
    pose_at(0, 0, 0),
    pose_at(30, 2, np.pi),
    pose_at(14, -14, np.pi / 2),
    pose_at(22, 12, -2.0),
)
Behaviour = Callable[[VehiclePort, VehicleScan], object]


@pytest.fixture(scope="module")
def scans() -> list[VehicleScan]:
    """Four vehicles; one of them has a ghost in its scan."""
    seen: list[tuple[Box, ...]] = [(_CAR,)] * 4
    seen[_VICTIM] = (_CAR, _GHOST)
    # What is compiled when it is called first is so before clocks run.
    scan = scan_of(_POSES[0], _CAR)
    regions = ClusterProposer()(scan.points)
    count_rays(observe(scan), claim(observe(scan), regions), regions, WitnessMargins())
    return [scan_of(pose, *boxes) for pose, boxes in zip(_POSES, seen, strict=True)]


def _sound(port: VehiclePort, scan: VehicleScan) -> object:
    return take_part(port, 7, scan, ClusterProposer())


def _run(
    scans: Sequence[VehicleScan],
    odd: Behaviour = _sound,
    faults: Faults = Faults(),
    seconds: float = 5.0,
    usual: Behaviour = _sound,
    constants: ConnectedConstants = ConnectedConstants(),
    budget: MessageBudget = MessageBudget(),
) -> tuple[InstantOutcome, Counter[str]]:
    """An instant; the last vehicle that joins behaves oddly."""
    with StationPort(len(scans)) as station:
        joining = threading.Thread(target=station.join, args=(10.0,))
        joining.start()
        # Numbers are given in the order of joining.
        lines = [Faults()] * (len(scans) - 1) + [faults]
        ports = [VehiclePort(station.number, line, seed) for seed, line in enumerate(lines)]
        joining.join()
        assert [port.number for port in ports] == list(range(len(scans)))
        vehicles = [
            threading.Thread(target=odd if index == len(scans) - 1 else usual, args=(port, scan))
            for index, (port, scan) in enumerate(zip(ports, scans, strict=True))
        ]
        for vehicle in vehicles:
            vehicle.start()
        outcome = judge_instant(station, 7, seconds, constants, budget)
        for port in ports:
            port.close()
        for vehicle in vehicles:
            vehicle.join()
        return outcome, station.tally


def _named_at(outcome: InstantOutcome, place: Box) -> int:
    away = np.linalg.norm(outcome.regions.centre[:, :2] - place[:2], axis=1)
    assert away.min() < 1.5
    return int(outcome.named[away.argmin()])


def test_the_victim_is_named_over_sockets(scans: list[VehicleScan]) -> None:
    outcome, tally = _run(scans)
    assert outcome.heard == (4, 4, 4)
    assert not tally
    assert _named_at(outcome, _GHOST) == _VICTIM
    assert _named_at(outcome, _CAR) < 0


def _length(_: int, content: bytes) -> int:
    return len(content)


def _silence(port: VehiclePort, scan: VehicleScan) -> None:
    pass


def _garbage(port: VehiclePort, scan: VehicleScan) -> None:
    port.send_bytes(np.random.default_rng(0).bytes(5000))


def _hang_up(port: VehiclePort, scan: VehicleScan) -> None:
    port.send_bytes(Packet(PacketStep.PROPOSALS, 7, bytes(100)).to_bytes()[:50])
    port.close()


def _noise_in_packets(port: VehiclePort, scan: VehicleScan) -> None:
    random = np.random.default_rng(1)
    for step in (PacketStep.PROPOSALS, PacketStep.CLAIMS, PacketStep.COUNTS):
        for about in range(4):
            port.send(Packet(step, 7, random.bytes(200), about))
            port.send(Packet(step, 8, random.bytes(200), about))


@pytest.mark.parametrize(
    ("odd", "faults"),
    [
        (_silence, Faults()),
        (_garbage, Faults()),
        (_hang_up, Faults()),
        (_noise_in_packets, Faults()),
        (_sound, Faults(lost=1.0)),
        (_sound, Faults(late=1.0)),
        (_sound, Faults(malformed=1.0)),
        (_sound, Faults(doubled=1.0)),
        (_sound, Faults(lost=0.5, late=0.5, doubled=0.5, malformed=0.5)),
    ],
)
def test_what_one_vehicle_does_changes_no_decision_about_the_others(
    scans: list[VehicleScan], odd: Behaviour, faults: Faults
) -> None:
    outcome, _ = _run(scans, odd, faults, seconds=1.2)
    assert outcome.heard[0] >= 3
    assert _named_at(outcome, _GHOST) == _VICTIM
    assert _named_at(outcome, _CAR) < 0


def test_what_came_twice_or_late_is_counted(scans: list[VehicleScan]) -> None:
    outcome, tally = _run(scans, faults=Faults(doubled=1.0))
    assert outcome.heard == (4, 4, 4)
    assert tally["doubled"] + tally["late"] >= 1
    outcome, tally = _run(scans, faults=Faults(malformed=1.0), seconds=1.2)
    assert tally.keys() <= {"malformed", "late", "doubled"}


def test_what_comes_too_early_is_kept_and_what_comes_late_is_not() -> None:
    with StationPort(1) as station:
        joining = threading.Thread(target=station.join, args=(5.0,))
        joining.start()
        port = VehiclePort(station.number)
        joining.join()
        for step, instant in (
            (PacketStep.CLAIMS, 4),
            (PacketStep.PROPOSALS, 5),
            (PacketStep.PROPOSALS, 4),
        ):
            port.send(Packet(step, instant, b"abc"))
        assert station.gather(PacketStep.PROPOSALS, 4, _length, 5.0) == {(0, 0): 3}
        assert station.gather(PacketStep.CLAIMS, 4, _length, 5.0) == {(0, 0): 3}
        port.send(Packet(PacketStep.CLAIMS, 4, b"late"))
        assert station.gather(PacketStep.PROPOSALS, 5, _length, 5.0) == {(0, 0): 3}
        assert station.gather(PacketStep.CLAIMS, 5, _length, 0.2) == {}
        assert station.tally == {"late": 1}
        # A flood of later packets is not kept.
        for _ in range(50):
            port.send(Packet(PacketStep.CLAIMS, 99, b"abc"))
        station.gather(PacketStep.CLAIMS, 6, _length, 0.2)
        assert station.tally["too early"] == 42
        port.close()


def test_each_damaged_packet_is_counted_once() -> None:
    with StationPort(1) as station:
        joining = threading.Thread(target=station.join, args=(5.0,))
        joining.start()
        port = VehiclePort(station.number)
        joining.join()
        damaged = bytearray(Packet(PacketStep.PROPOSALS, 4, b"abc").to_bytes())
        damaged[-1] ^= 1
        for instant in (4, 5):
            port.send_bytes(bytes(damaged) * 2)
            port.send(Packet(PacketStep.PROPOSALS, instant, b"abc"))
            assert station.gather(PacketStep.PROPOSALS, instant, _length, 5.0) == {(0, 0): 3}
        assert station.tally == {"malformed": 4}
        port.close()


def test_no_vehicles_end_in_no_regions() -> None:
    with StationPort(3) as station:
        assert station.join(0.05) == 0
        outcome = judge_instant(station, 0, 0.05)
    assert len(outcome.regions) == len(outcome.named) == 0
    assert outcome.heard == (0, 0, 0)


def test_a_vehicle_without_a_base_station_is_told_so() -> None:
    with StationPort(1) as station:
        number = station.number
    with pytest.raises(DataError, match="No base station"):
        VehiclePort(number)
    with pytest.raises(ConfigurationError):
        Faults(lost=2.0)
    with pytest.raises(ConfigurationError):
        StationPort(0)


def test_a_vehicle_leaves_when_the_base_station_falls_silent(scans: list[VehicleScan]) -> None:
    with StationPort(1) as station:
        joining = threading.Thread(target=station.join, args=(5.0,))
        joining.start()
        port = VehiclePort(station.number)
        joining.join()
        assert not take_part(port, 7, scans[0], ClusterProposer(), seconds=0.1)
        port.close()


def test_sockets_decide_as_one_process_does(scans: list[VehicleScan]) -> None:
    constants = read_connected_fit(SHIPPED_FIT).constants()
    # Of vehicles that drive, each with so much to tell that it does not fit into the budget.
    driving = [replace(scan, sweep=RollingSweep(8.0, 0.3)) for scan in scans]
    budget = MessageBudget(512)
    expected = ConnectedValidator(constants, budget=budget).validate(driving)

    def narrow(port: VehiclePort, scan: VehicleScan) -> object:
        return take_part(port, 7, scan, ClusterProposer(), margins=constants.margins, budget=budget)

    outcome, tally = _run(driving, narrow, usual=narrow, constants=constants, budget=budget)
    assert not tally
    np.testing.assert_array_equal(outcome.regions.centre, expected.regions.centre)
    np.testing.assert_array_equal(outcome.named, expected.named)
    assert outcome.traffic.sent == expected.traffic.sent
    assert max(each.total() for each in outcome.traffic.sent) <= budget.nbytes


def test_who_exceeds_the_budget_is_refused(scans: list[VehicleScan]) -> None:
    outcome, tally = _run(scans, budget=MessageBudget(256), seconds=1.2)
    assert outcome.heard[2] < 4
    assert outcome.traffic.refused
    assert tally["malformed"] == len(outcome.traffic.refused)
