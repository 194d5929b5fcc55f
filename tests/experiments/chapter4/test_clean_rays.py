"""What can be decided on a street of boxes, where it is plain who sees what."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.attacks.object_scan import ObjectScan
from avsec_gym.experiments.chapter4.clean_rays import CleanRays
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.recordings import RecordedInstant
from tests.validation.connected.conftest import POSES, Box, car_regions, pose_at, scan_of

_CAR: Box = (14.0, 3.0, 0.1)


def _instant(*seen: tuple[Box, ...], off: float = 0.0) -> RecordedInstant:
    """Vehicles that see these cars, and measure their poses so far off, metres."""
    true = POSES[: len(seen)]
    scans = [scan_of(pose, *boxes) for pose, boxes in zip(true, seen, strict=True)]
    wrong = [replace(scan, pose=pose_at(off, 0, 0) @ scan.pose) for scan in scans]
    return RecordedInstant("a", tuple(wrong), true_poses=true)


def _ghost(instant: RecordedInstant, x: float, y: float) -> AttackedInstant:
    """A low ghost of the first vehicle, 0.5 to 0.9 m above the ground."""
    grid = np.mgrid[-0.8:0.9:0.1, -0.8:0.9:0.1, 0.5:0.9:0.1].reshape(3, -1).T
    points = np.c_[grid, np.full(len(grid), 0.3)].astype(np.float32)
    scan, distance = ObjectScan(points, (1.0, 1.8, 1.8), (-10.0, 0.0)), float(np.hypot(x, y))
    attack = PastedObject(0, (distance, distance), float(np.arctan2(y, x)), scan)
    attacked = attack.attack(instant)
    assert attacked is not None
    return attacked


@pytest.mark.parametrize("off", [0.0, 2.0])
def test_a_region_is_decidable_where_one_vehicle_sees_what_another_claims(off: float) -> None:
    regions = car_regions(_CAR, (40.0, -30.0, 0.0))
    for seen, decidable in (((_CAR,), True), ((), True)):
        # Rays of the second vehicle end on the car, or pass where the first one claims it.
        instant = _instant((_CAR,), seen, off=off)
        assert CleanRays(instant).decidable(regions).tolist() == [decidable, False]
    assert not CleanRays(_instant((), ())).decidable(regions).any()


def test_a_region_is_decidable_whatever_is_decided_beside_it() -> None:
    places = [_CAR, *((200.0 + 6 * number, 0.0, 0.0) for number in range(40))]
    rays = CleanRays(_instant((_CAR,), (_CAR,)))
    for first in (0, 20, 40):
        regions = car_regions(*places[1 : first + 1], _CAR, *places[first + 1 :])
        assert np.flatnonzero(rays.decidable(regions)).tolist() == [first]


@pytest.mark.parametrize("off", [0.0, 2.0])
def test_witnesses_of_a_ghost_are_those_whose_rays_reach_it(off: float) -> None:
    # A car stands right between the second vehicle, at (34, 2), and the second place.
    car: Box = (20.0, 2.0, np.pi / 2)
    for seen, place, witnesses in (
        ((), (16.0, 2.0), 1),
        ((car,), (16.0, 2.0), 0),
        ((car,), (8.0, 9.0), 1),
    ):
        instant = _instant((), seen, off=off)
        # The victim sees no car, so that it puts a ghost anywhere.
        assert CleanRays(instant).witnesses(_ghost(instant, *place)) == witnesses


def test_witnesses_of_a_removal_are_those_that_claim_what_the_victim_sees() -> None:
    for others, witnesses in ((((_CAR,), (_CAR,)), 2), (((_CAR,), ()), 1), (((), ()), 0)):
        instant = _instant((_CAR,), *others)
        attacked = RemovedObject(vehicle=0).attack(instant)
        assert attacked is not None
        assert CleanRays(instant).witnesses(attacked) == witnesses
