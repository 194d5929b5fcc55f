"""The whole of the thesis' method on streets made by hand."""

from collections.abc import Callable

import numpy as np
import pytest

from avsec_gym.validation.connected.base_station import (
    complete_set_of_regions,
    decide,
    region_distances,
)
from avsec_gym.validation.connected.ground_epsilon import ground_epsilon
from avsec_gym.validation.connected.messages.crop_message import CropMessage
from avsec_gym.validation.connected.messages.region_message import RegionMessage
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.vehicle import propose_regions, scan_of_regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

Street = Callable[..., list[VehicleScan]]
_CAR, _GHOST = (14.0, 3.0, 0.1), (15.0, -3.0, -0.2)


def _messages(scans: list[VehicleScan]) -> tuple[RegionMessage, list[CropMessage]]:
    proposer = ClusterProposer()
    proposed = [propose_regions(i, scan, proposer).to_bytes() for i, scan in enumerate(scans)]
    complete = complete_set_of_regions([RegionMessage.from_bytes(each) for each in proposed])
    crops = [scan_of_regions(i, scan, complete).to_bytes() for i, scan in enumerate(scans)]
    return complete, [CropMessage.from_bytes(each) for each in crops]


def _at(complete: RegionMessage, place: tuple[float, float, float]) -> int:
    """The region at a place; it is there."""
    away = np.linalg.norm(complete.regions.centre + complete.pose[:3, 3] - [*place[:2], 0], axis=1)
    assert away.min() < 1.0
    return int(away.argmin())


@pytest.mark.parametrize("victim", range(3))
def test_a_ghost_in_one_scan_names_its_vehicle(street: Street, victim: int) -> None:
    seen = [(_CAR, _GHOST) if vehicle == victim else (_CAR,) for vehicle in range(3)]
    complete, crops = _messages(street(*seen))
    assert len(complete.regions) == 2
    decisions = decide(region_distances(complete, crops, 3), 0.8)
    assert decisions[_at(complete, _GHOST)].attacked == {victim}
    assert decisions[_at(complete, _CAR)].attacked == frozenset()


@pytest.mark.parametrize("victim", range(3))
def test_an_object_that_one_scan_lacks_names_its_vehicle(street: Street, victim: int) -> None:
    seen = [() if vehicle == victim else (_CAR,) for vehicle in range(3)]
    complete, crops = _messages(street(*seen))
    decision = decide(region_distances(complete, crops, 3), 0.8)[_at(complete, _CAR)]
    assert decision.alarm
    # Of vehicle 0, which sees the car's rear, and 2, which sees its side, no cells are the same.
    comparable = victim != 1
    assert np.isnan(decision.distances[0, 2]) == (not comparable)
    assert decision.attacked == ({victim} if comparable else frozenset())


def test_epsilon_of_a_flat_street_is_nearly_nothing(street: Street) -> None:
    scans = street((), (), ())
    assert ground_epsilon([scans]) < 1e-3
    # A vehicle that measures itself 6 cm too high is so far from the others.
    raised = scans[0].pose.copy()
    raised[2, 3] += 0.06
    epsilon = ground_epsilon([[VehicleScan(scans[0].points, raised), scans[1]]])
    assert epsilon == pytest.approx(0.06, abs=1e-3)


def test_a_vehicle_that_answers_for_other_regions_changes_nothing(street: Street) -> None:
    complete, crops = _messages(street((_CAR,), (_CAR,), (_CAR,)))
    alone = region_distances(complete, crops[:2], 3)
    for strange in (CropMessage(2, ()), CropMessage(7, crops[2].crops)):
        assert region_distances(complete, [*crops[:2], strange], 3) == pytest.approx(
            alone, nan_ok=True
        )


def test_no_proposals_make_an_empty_set() -> None:
    scan = VehicleScan(np.zeros((0, 4), np.float32), np.eye(4))
    complete, crops = _messages([scan, scan])
    assert len(complete.regions) == 0
    assert region_distances(complete, crops, 2).shape == (0, 2, 2)
