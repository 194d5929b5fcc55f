"""An instant of evidence by rays between processes: the base station's part, and a vehicle's.

    vehicles   proposals ->             claims ->            counts ->
    station              -> regions               -> claims            -> who is attacked

Each step ends when all have answered or its time is over; what is missing then is missing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.accusation import lone_authors, upheld_by_rays
from avsec_gym.validation.connected.admission import admitted_counts, admitted_proposals
from avsec_gym.validation.connected.base_station import complete_set_of_regions
from avsec_gym.validation.connected.merging import regions_in_world
from avsec_gym.validation.connected.messages.region_message import RegionMessage
from avsec_gym.validation.connected.rays.claim_message import decode_claims, encode_claims
from avsec_gym.validation.connected.rays.claims import claim, claimed_layers
from avsec_gym.validation.connected.rays.decision import DecisionRule, decide
from avsec_gym.validation.connected.rays.observer import observe
from avsec_gym.validation.connected.rays.rates import RayRates
from avsec_gym.validation.connected.rays.witness import WitnessMargins
from avsec_gym.validation.connected.rays.witness_counts import (
    count_rays,
    decode_counts,
    encode_counts,
)
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.transport.packets import Packet, PacketStep
from avsec_gym.validation.connected.transport.station_port import StationPort
from avsec_gym.validation.connected.transport.vehicle_port import VehiclePort
from avsec_gym.validation.connected.vehicle import RegionProposer, propose_regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan


@dataclass(frozen=True, eq=False)
class InstantOutcome:
    """What the base station makes of an instant.

    Args:
        regions: The complete set, world frame, R of them.
        named: The vehicle whose LiDAR is attacked, `CANNOT_TELL` or `NO_ATTACK`, shape (R,).
        heard: Number of vehicles whose proposals, whose claims and of whom some counts came in.
    """

    regions: Regions
    named: NDArray[np.int64]
    heard: tuple[int, int, int]


def judge_instant(
    port: StationPort,
    instant: int,
    seconds: float = 1.0,
    rates: RayRates = RayRates(),
    rule: DecisionRule = DecisionRule(),
) -> InstantOutcome:
    """The base station's part.

    Args:
        port: The vehicles that have joined.
        instant: Number of the instant.
        seconds: How long it waits at each of the three steps.
        rates: The chances of rays.
        rule: How evidence becomes a decision.
    """
    proposed = port.gather(PacketStep.PROPOSALS, instant, RegionMessage.from_bytes, seconds)
    # The number of a sender is that of its connection, whatever the message claims.
    taken = admitted_proposals(
        RegionMessage(sender, each.pose, each.regions) for (sender, _), each in proposed.items()
    )
    content = complete_set_of_regions(taken).to_bytes()
    port.broadcast(Packet(PacketStep.REGIONS, instant, content))
    regions = _regions(content)

    claims = port.gather(
        PacketStep.CLAIMS, instant, lambda sent: decode_claims(sent, regions), seconds
    )
    claimed = {sender: each for (sender, _), each in claims.items()}
    for sender, each in claimed.items():
        port.broadcast(Packet(PacketStep.CLAIMS, instant, encode_claims(each), sender))
    port.broadcast(Packet(PacketStep.WITNESS, instant, b""))

    said = port.gather(
        PacketStep.COUNTS, instant, lambda sent: decode_counts(sent, regions), seconds, claimed
    )
    counts = np.zeros((len(regions), port.vehicles, port.vehicles, 3), np.int64)
    for (witness, about), seen in said.items():
        kept = admitted_counts(seen, claimed[about])
        counts[kept.region, about, witness] = kept.counts
    layers = claimed_layers(claimed, regions, counts.shape[1])
    proposals = {each.sender: regions_in_world(each.regions, each.pose) for each in taken}
    named = upheld_by_rays(
        decide(counts, rates, rule), counts, layers, lone_authors(regions, proposals), rates, rule
    )
    return InstantOutcome(
        regions, named, (len(taken), len(claimed), len({witness for witness, _ in said}))
    )


def take_part(
    port: VehiclePort,
    instant: int,
    scan: VehicleScan,
    proposer: RegionProposer,
    seconds: float = 3.0,
    margins: WitnessMargins = WitnessMargins(),
) -> bool:
    """A vehicle's part.

    Args:
        port: The vehicle's connection to the base station.
        instant: Number of the instant.
        scan: The vehicle's scan, with the pose that it measured.
        proposer: The function that proposes regions all around.
        seconds: How long it waits for the base station at each step.
        margins: What may lie apart.

    Returns:
        Whether it came to its end; False if the base station fell silent.
    """
    proposals = propose_regions(port.number, scan, proposer).to_bytes()
    port.send(Packet(PacketStep.PROPOSALS, instant, proposals))
    observer = observe(scan)
    regions = Regions.empty()
    while (packet := port.receive(seconds)) is not None:
        if packet.instant != instant:
            continue
        try:
            if packet.step == PacketStep.REGIONS:
                regions = _regions(packet.content)
                mine = encode_claims(claim(observer, regions))
                port.send(Packet(PacketStep.CLAIMS, instant, mine))
            elif packet.step == PacketStep.CLAIMS and packet.about != port.number:
                others = decode_claims(packet.content, regions)
                seen = encode_counts(count_rays(observer, others, regions, margins))
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
