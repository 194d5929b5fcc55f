"""Recovery: the ghost is gone, the hidden car is back, and nothing else changes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.recovery import recovered_scan
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import Box, car_regions

_CAR, _GHOST = (14.0, 3.0, 0.1), (15.0, -4.0, -0.2)
Street = Callable[..., list[VehicleScan]]


def _inside(scan: VehicleScan, box: Box, above: float = 0.16) -> int:
    """Points on a car, without those of the ground."""
    world = scan.in_world()
    return int((car_regions(box).grown(0.3, 0.3).contains(0, world) & (world[:, 2] > above)).sum())


def _nearest(scan: VehicleScan, box: Box) -> float:
    """From a car to the nearest thing that the vehicle proposes, metres."""
    own = np.linalg.inv(scan.pose) @ [*box[:2], 0.0, 1.0]
    proposed: Regions = ClusterProposer()(scan.compensated().points)
    return float(np.hypot(*(proposed.centre[:, :2] - own[:2]).T).min(initial=np.inf))


def test_a_ghost_is_taken_out_and_the_car_stays(street: Street) -> None:
    scans = street((_CAR,), (_CAR, _GHOST), (_CAR,))
    result = ConnectedValidator().validate(scans)
    recovered = recovered_scan(scans[1], 1, result)
    assert _inside(scans[1], _GHOST) > 100
    assert _inside(recovered, _GHOST) == 0
    assert _nearest(recovered, _GHOST) > 3
    assert _inside(recovered, _CAR) == _inside(scans[1], _CAR)
    gone = len(scans[1].points) - len(recovered.points)
    assert gone == pytest.approx(_inside(scans[1], _GHOST), rel=0.02)
    for honest in (0, 2):
        assert recovered_scan(scans[honest], honest, result) is scans[honest]


@pytest.mark.parametrize("sweep", [RollingSweep(), RollingSweep(15.0, 0.1)])
def test_a_removed_car_is_put_back_where_the_others_see_it(
    sweep: RollingSweep, street: Street
) -> None:
    scans = street((_CAR,), (), (_CAR,))
    rolled = sweep.rolled(scans[1].points[:, :3].astype(float))
    points = np.c_[rolled, scans[1].points[:, 3]].astype(np.float32)
    scans[1] = VehicleScan(points, scans[1].pose, 0.0, sweep)
    result = ConnectedValidator().validate(scans)
    recovered = recovered_scan(scans[1], 1, result)
    assert result.accused == (1,)
    assert _inside(scans[1], _CAR) == 0
    put_back = recovered.points[len(points) :]
    assert 30 < len(put_back) <= 1.05 * _inside(recovered, _CAR)
    assert _nearest(recovered, _CAR) < 1
    np.testing.assert_array_equal(recovered.points[: len(points)], points)


def test_surfaces_have_no_claims_to_recover_from(street: Street) -> None:
    scans = street((_CAR,), (_CAR, _GHOST), (_CAR,))
    result = ConnectedValidator(method="surfaces").validate(scans)
    with pytest.raises(DataError, match="method 'rays'"):
        recovered_scan(scans[1], 1, result)
