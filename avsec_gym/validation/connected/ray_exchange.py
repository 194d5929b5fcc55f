"""An instant by evidence of rays: vehicles claim, all others bear witness, the station decides."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.accusation import upheld_by_rays
from avsec_gym.validation.connected.admission import admitted_counts
from avsec_gym.validation.connected.budget import MessageBudget
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.merged_proposals import MergedProposals
from avsec_gym.validation.connected.rays.claim_message import decode_claims
from avsec_gym.validation.connected.rays.claims import SEARCHED, Claims, claim, claimed_layers
from avsec_gym.validation.connected.rays.decision import Decision, decide
from avsec_gym.validation.connected.rays.observer import Observer, observe
from avsec_gym.validation.connected.rays.rates import RayRates, decidable
from avsec_gym.validation.connected.rays.witness import WitnessMargins
from avsec_gym.validation.connected.rays.witness_counts import (
    WitnessCounts,
    count_rays,
    decode_counts,
    encode_counts,
)
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.traffic import MessageKind, SentMessages
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

RegionVelocities = Callable[[Regions], Floats]
"""How fast what is in each region moves by a vehicle's own tracking: along the world's x and y,
m/s, shape (R, 2)."""


@dataclass(frozen=True, eq=False)
class Testimonies:
    """What the base station has heard of R regions and V vehicles.

    Args:
        counts: What witness ``k`` reports of the claim of ``j``, 0 where it does not, shape
            (R, V, V, 3).
        layers: The number of layers of voxels in which each vehicle's claim lies, 0 without one,
            shape (R, V).
        claims: The vehicles' claims, by number, of those whose claims were taken.
    """

    counts: NDArray[np.int64]
    layers: NDArray[np.int64]
    claims: Mapping[int, Claims]


def exchange_rays(
    scans: Sequence[VehicleScan],
    merged: MergedProposals,
    margins: WitnessMargins,
    traffic: SentMessages,
    budget: MessageBudget,
    motions: Sequence[RegionVelocities] | None = None,
) -> Testimonies:
    """Claims of all, and how all others' rays support them.

    Args:
        scans: The scan of each vehicle, by number.
        merged: The regions.
        margins: What may lie apart.
        traffic: The record that takes the messages.
        budget: The budget of each vehicle.
        motions: What each vehicle knows of what moves; None: all stands.
    """
    regions, others = merged.regions, len(scans) - 1
    at_intervals = bool(np.ptp([scan.time for scan in scans]) > SEARCHED)
    # Each vehicle claims what its rays end on in the regions, and sends that to all.
    observers, claimed = [], dict[int, Claims]()
    for number, scan in enumerate(scans):
        with traffic.step("claim"):
            observers.append(observe(scan))
            velocity = None if motions is None else motions[number](regions)
            spent = traffic.sent[number].total()
            content = message_of_claims(observers[number], regions, budget, spent, velocity)

        def decoded(sent: bytes) -> tuple[Claims, bytes]:
            return decode_claims(sent, regions, at_intervals=at_intervals), sent

        read = traffic.send(MessageKind.CLAIMS, number, content, decoded)
        # Of a vehicle with several messages the first counts; all others get it as it came.
        if read:
            claimed[number], message = read[0]
            traffic.broadcast("claims", message)
    # Each vehicle counts how its own rays support the claims of every other one.
    answers = dict[tuple[int, int], WitnessCounts]()
    for witness, observer in enumerate(observers):
        for about, claims in claimed.items():
            if about == witness:
                continue
            with traffic.step("witness"):
                further = [claimed[each] for each in claimed if each not in (about, witness)]
                third = further if at_intervals else None
                content = message_of_counts(
                    observer, claims, regions, margins, budget, others, third
                )
            read_counts = traffic.send(
                MessageKind.COUNTS, witness, content, lambda sent: decode_counts(sent, regions)
            )
            if read_counts:
                answers[about, witness] = read_counts[0]
    return testimonies_of(claimed, answers, merged, len(scans))


def message_of_claims(
    observer: Observer,
    regions: Regions,
    budget: MessageBudget,
    spent: int,
    velocity: Floats | None = None,
) -> bytes:
    """A vehicle's part: what its rays end on in the regions.

    Args:
        observer: The rays of the vehicle.
        regions: The complete set, world frame, R of them.
        budget: The budget of the vehicle.
        spent: Bytes that its proposals took.
        velocity: How fast what is in each region moves by its own tracking, m/s, shape (R, 2);
            None: all stands.
    """
    return budget.message_of_claims(claim(observer, regions, velocity), spent)


def message_of_counts(
    observer: Observer,
    claims: Claims,
    regions: Regions,
    margins: WitnessMargins,
    budget: MessageBudget,
    others: int,
    further: Sequence[Claims] | None = None,
) -> bytes:
    """A vehicle's part: how its own rays support the claims of another one.

    Args:
        observer: The rays of the vehicle.
        claims: What the other one claims.
        regions: The complete set, world frame.
        margins: What may lie apart.
        budget: The budget of the vehicle.
        others: Number of the other vehicles, all of which it answers.
        further: What third vehicles claim, of scans that are taken at intervals; else None.
    """
    seen = count_rays(observer, claims, regions, margins, further)
    return encode_counts(budget.counts_within(seen, others))


def testimonies_of(
    claimed: Mapping[int, Claims],
    answers: Mapping[tuple[int, int], WitnessCounts],
    merged: MergedProposals,
    vehicles: int,
) -> Testimonies:
    """The base station's part: what it takes of all that it has read.

    Args:
        claimed: The vehicles' claims, by number.
        answers: What is reported of claims, by the numbers of who claims and who bears witness.
        merged: The regions.
        vehicles: Number of vehicles.
    """
    regions = merged.regions
    counts = np.zeros((len(regions), vehicles, vehicles, 3), np.int64)
    for (about, witness), seen in answers.items():
        # Whose claims cannot be read is left out of the instant: it bears no witness, either.
        if witness not in claimed:
            continue
        kept = admitted_counts(seen, claimed[about])
        counts[kept.region, about, witness] = kept.counts
    # Of the regions in which it stands itself a vehicle sees nothing.
    for witness in range(vehicles):
        counts[merged.stands_in(witness), :, witness] = 0
    return Testimonies(counts, claimed_layers(claimed, regions, vehicles), claimed)


def decide_by_rays(
    heard: Testimonies, merged: MergedProposals, constants: ConnectedConstants
) -> Decision:
    """What the base station decides, with accusations that enough independent vehicles uphold."""
    rates, rule = constants.rates, constants.rule
    decision = decide(heard.counts, rates, rule)
    named = upheld_by_rays(decision, heard.counts, heard.layers, merged.authors, rates, rule)
    return Decision(decision.score, decision.probability, decision.ghost, decision.removal, named)


def is_decidable(counts: NDArray[np.int64], rates: RayRates) -> NDArray[np.bool_]:
    """Whether some vehicle bears witness of another's claim in each region, shape (R,)."""
    return np.asarray(decidable(counts, rates).any(axis=(1, 2)))
