"""Steps 1 and 2 of an instant: all vehicles propose, and the base station's set goes to all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.accusation import lone_authors
from avsec_gym.validation.connected.admission import admitted_proposals
from avsec_gym.validation.connected.base_station import complete_set_of_regions
from avsec_gym.validation.connected.budget import MessageBudget
from avsec_gym.validation.connected.merging import regions_in_world, stands_in
from avsec_gym.validation.connected.messages.region_message import RegionMessage
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.traffic import MessageKind, SentMessages
from avsec_gym.validation.connected.vehicle import RegionProposer, propose_regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan


@dataclass(frozen=True, eq=False)
class MergedProposals:
    """What is to be compared.

    Args:
        complete_set: The message that all vehicles got.
        regions: The set's regions in the world, R of them.
        of_vehicles: What the base station took of each vehicle's proposals, world frame.
        poses: The pose that each vehicle reported, of those whose proposals were taken.
        roadside: The numbers of fixed LiDARs beside the road, which the base station knows by their
            connection: a vehicle that pretends to be one gains nothing.
    """

    complete_set: RegionMessage
    regions: Regions
    of_vehicles: Mapping[int, Regions]
    poses: Mapping[int, Floats]
    roadside: frozenset[int] = frozenset()

    @property
    def authors(self) -> NDArray[np.int64]:
        """Lone author of each region, shape (R,)."""
        return lone_authors(self.regions, self.of_vehicles)

    def stands_in(self, vehicle: int) -> NDArray[np.bool_]:
        """Whether a vehicle itself stands in each region, of which it sees nothing, shape (R,)."""
        if vehicle not in self.poses or vehicle in self.roadside or not len(self.regions):
            return np.zeros(len(self.regions), bool)
        return stands_in(self.regions, self.poses[vehicle])


def merge_proposals(
    scans: Sequence[VehicleScan],
    proposer: RegionProposer,
    traffic: SentMessages,
    budget: MessageBudget | None,
) -> MergedProposals:
    """Propose, send, admit, merge, distribute.

    Args:
        scans: The scan of each vehicle, by number.
        proposer: The function that proposes regions all around.
        traffic: The record that takes the messages.
        budget: What proposals may take of it; None: all are sent.
    """
    arrived: list[RegionMessage] = []
    for number, scan in enumerate(scans):
        with traffic.step("propose"):
            message = proposals_of(number, scan, proposer, budget)
        read = traffic.send(
            MessageKind.PROPOSALS, number, message.to_bytes(), RegionMessage.from_bytes
        )
        # The number of a sender is that of its connection, whatever the message states.
        arrived += [RegionMessage(number, each.pose, each.regions) for each in read]
    with traffic.step("merge"):
        taken = admitted_proposals(arrived)
        content = complete_set_of_regions(taken).to_bytes()
        traffic.broadcast("regions", content)
        roadside = frozenset(number for number, scan in enumerate(scans) if scan.roadside)
        return merged_of(taken, content, roadside)


def proposals_of(
    number: int, scan: VehicleScan, proposer: RegionProposer, budget: MessageBudget | None
) -> RegionMessage:
    """A vehicle's part: the regions of its scan.

    Args:
        number: Number of the vehicle.
        scan: The vehicle's scan.
        proposer: The function that proposes regions all around.
        budget: What proposals may take of it; None: all are sent.
    """
    message = propose_regions(number, scan.compensated(), proposer)
    return message if budget is None else budget.proposals_within(message)


def merged_of(
    taken: Sequence[RegionMessage], content: bytes, roadside: frozenset[int] = frozenset()
) -> MergedProposals:
    """The base station's part: what is to be compared, read as all vehicles read it.

    Args:
        taken: The proposals that were taken, one message of each vehicle.
        content: The message of the complete set that went to all.
        roadside: The numbers of fixed LiDARs beside the road.
    """
    complete_set = RegionMessage.from_bytes(content)
    return MergedProposals(
        complete_set,
        regions_in_world(complete_set.regions, complete_set.pose),
        {each.sender: regions_in_world(each.regions, each.pose) for each in taken},
        {each.sender: each.pose for each in taken},
        roadside,
    )
