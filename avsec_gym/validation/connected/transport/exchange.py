"""An instant of evidence by rays between processes: the base station's part, and a vehicle's.

    vehicles   proposals ->             claims ->            counts ->
    station              -> regions               -> claims            -> who is attacked

Each step ends when all have answered or its time is over; what is missing then is missing. What is
sent, and what is decided of it, are the steps of `exchange_rays`, for vehicles that look at one
instant: scans that are taken at intervals are compared in one process.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.admission import admitted_proposals
from avsec_gym.validation.connected.base_station import complete_set_of_regions
from avsec_gym.validation.connected.budget import MessageBudget
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.merged_proposals import merged_of, proposals_of
from avsec_gym.validation.connected.merging import regions_in_world
from avsec_gym.validation.connected.messages.region_message import RegionMessage
from avsec_gym.validation.connected.ray_exchange import (
    decide_by_rays,
    message_of_claims,
    message_of_counts,
    testimonies_of,
)
from avsec_gym.validation.connected.rays.claim_message import decode_claims
from avsec_gym.validation.connected.rays.claims import Claims
from avsec_gym.validation.connected.rays.observer import observe
from avsec_gym.validation.connected.rays.witness import WitnessMargins
from avsec_gym.validation.connected.rays.witness_counts import decode_counts
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.traffic import MessageKind, SentMessages
from avsec_gym.validation.connected.transport.packets import Packet, PacketStep
from avsec_gym.validation.connected.transport.station_port import StationPort
from avsec_gym.validation.connected.transport.vehicle_port import VehiclePort
from avsec_gym.validation.connected.vehicle import RegionProposer
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

_Message = TypeVar("_Message")


@dataclass(frozen=True, eq=False)
class InstantOutcome:
    """What the base station makes of an instant.

    Args:
        regions: The complete set, world frame, R of them.
        named: The vehicle whose LiDAR is attacked, `CANNOT_TELL` or `NO_ATTACK`, shape (R,).
        heard: Number of vehicles whose proposals, whose claims and of whom some counts came in.
        traffic: What was taken, with its bytes, and what was refused.
    """

    regions: Regions
    named: NDArray[np.int64]
    heard: tuple[int, int, int]
    traffic: SentMessages


def judge_instant(
    port: StationPort,
    instant: int,
    seconds: float = 1.0,
    constants: ConnectedConstants = ConnectedConstants(),
    budget: MessageBudget = MessageBudget(),
) -> InstantOutcome:
    """The base station's part.

    Args:
        port: The vehicles that have joined.
        instant: Number of the instant.
        seconds: How long it waits at each of the three steps.
        constants: What evidence is worth; see `ConnectedFit.constants`.
        budget: What a vehicle may send; what exceeds it is refused.
    """
    traffic = SentMessages(port.vehicles, most_bytes=budget.nbytes)

    def reader(
        kind: MessageKind, read: Callable[[bytes], _Message]
    ) -> Callable[[int, bytes], _Message]:
        """Reads what keeps to the budget of its sender, the number of whose connection is known."""

        def checked(sender: int, content: bytes) -> _Message:
            taken = traffic.send(kind, sender, content, read)
            if not taken:
                raise DataError(traffic.refused[-1])
            return taken[0]

        return checked

    # Proposals, of which the complete set goes to all.
    proposed = port.gather(
        PacketStep.PROPOSALS,
        instant,
        reader(MessageKind.PROPOSALS, RegionMessage.from_bytes),
        seconds,
    )
    # The number of a sender is that of its connection, whatever the message claims.
    taken = admitted_proposals(
        RegionMessage(sender, each.pose, each.regions) for (sender, _), each in proposed.items()
    )
    content = complete_set_of_regions(taken).to_bytes()
    port.broadcast(Packet(PacketStep.REGIONS, instant, content))
    merged = merged_of(taken, content)
    regions = merged.regions

    # Claims, which go to all as they came.
    def with_bytes(sent: bytes) -> tuple[Claims, bytes]:
        return decode_claims(sent, regions), sent

    claims = port.gather(
        PacketStep.CLAIMS, instant, reader(MessageKind.CLAIMS, with_bytes), seconds
    )
    claimed = {sender: each for (sender, _), (each, _) in claims.items()}
    for (sender, _), (_, sent) in claims.items():
        port.broadcast(Packet(PacketStep.CLAIMS, instant, sent, sender))
    port.broadcast(Packet(PacketStep.WITNESS, instant, b""))

    # Counts, of which it decides.
    counted = port.gather(
        PacketStep.COUNTS,
        instant,
        reader(MessageKind.COUNTS, lambda sent: decode_counts(sent, regions)),
        seconds,
        claimed,
    )
    answers = {(about, witness): seen for (witness, about), seen in counted.items()}
    heard = testimonies_of(claimed, answers, merged, port.vehicles)
    named = decide_by_rays(heard, merged, constants).named
    witnesses = {witness for witness, _ in counted}
    return InstantOutcome(regions, named, (len(taken), len(claimed), len(witnesses)), traffic)


def take_part(
    port: VehiclePort,
    instant: int,
    scan: VehicleScan,
    proposer: RegionProposer,
    seconds: float = 3.0,
    margins: WitnessMargins = WitnessMargins(),
    budget: MessageBudget = MessageBudget(),
) -> bool:
    """A vehicle's part.

    Args:
        port: The vehicle's connection to the base station.
        instant: Number of the instant.
        scan: The vehicle's scan, with the pose that it measured.
        proposer: The function that proposes regions all around.
        seconds: How long it waits for the base station at each step.
        margins: What may lie apart.
        budget: What it may send.

    Returns:
        Whether it came to its end; False if the base station fell silent.
    """
    proposals = proposals_of(port.number, scan, proposer, budget).to_bytes()
    port.send(Packet(PacketStep.PROPOSALS, instant, proposals))
    observer = observe(scan)
    regions = Regions.empty()
    while (packet := port.receive(seconds)) is not None:
        if packet.instant != instant:
            continue
        try:
            if packet.step == PacketStep.REGIONS:
                regions = _regions(packet.content)
                mine = message_of_claims(observer, regions, budget, len(proposals))
                port.send(Packet(PacketStep.CLAIMS, instant, mine))
            elif packet.step == PacketStep.CLAIMS and packet.about != port.number:
                others = decode_claims(packet.content, regions)
                seen = message_of_counts(
                    observer, others, regions, margins, budget, port.vehicles - 1
                )
                port.send(Packet(PacketStep.COUNTS, instant, seen, packet.about))
            elif packet.step == PacketStep.WITNESS:
                return True
        except DataError:
            continue  # It is the base station's turn to send what can be read.
    return False


def _regions(content: bytes) -> Regions:
    """The complete set in the world, as its bytes have it: the same for every vehicle."""
    complete = RegionMessage.from_bytes(content)
    return regions_in_world(complete.regions, complete.pose)
