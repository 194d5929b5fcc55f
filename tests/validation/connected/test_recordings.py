"""Instants of a data set become scans with the poses that are asked for."""

from types import SimpleNamespace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.recordings import recorded_instants
from avsec_gym.world.export import SensorVehicle


def _world(sweep: str = "instant") -> SimpleNamespace:
    true, measured = np.eye(4), np.eye(4)
    measured[0, 3] = 0.2
    frame = SimpleNamespace(points=np.ones((3, 4), np.float32))
    views = [SimpleNamespace(frame=frame, pose=true, measured_pose=measured, time=0.05)]
    truth = SimpleNamespace(vehicles=[SensorVehicle(0, 0.05, 12.0, 0.0)])
    return SimpleNamespace(
        ids=lambda: ["000000", "000001"],
        views=lambda id: views,
        instant=lambda id: truth,
        sweep=sweep,
    )


@pytest.mark.parametrize(("poses", "x"), [("measured", 1.2), ("true", 1.0)])
def test_scans_have_the_poses_that_are_asked_for(poses: str, x: float) -> None:
    instants = list(recorded_instants(_world(), poses))  # type: ignore[arg-type]
    assert [instant.id for instant in instants] == ["000000", "000001"]
    assert all(instant.truth is not None for instant in instants)
    [scan] = instants[0].scans
    assert scan.time == 0.05
    assert scan.in_world()[0].tolist() == [x, 1.0, 1.0]


def test_rolling_scans_are_compensated_by_the_vehicles_odometry() -> None:
    # The head faces (1, 1) an eighth of a turn after the scan's time: 12 m/s for 12.5 ms.
    [scan] = next(recorded_instants(_world("rolling"), "true")).scans  # type: ignore[arg-type]
    assert scan.in_world()[0, 0] == pytest.approx(1.0 + 12.0 * 0.0125, abs=1e-5)
    [scan] = next(recorded_instants(_world("compensated"), "true")).scans  # type: ignore[arg-type]
    assert (scan.sweep.speed, scan.sweep.period) == (0.0, 0.1)


def test_some_instants_only_and_no_other_poses() -> None:
    chosen = recorded_instants(_world(), ids=["000001"])  # type: ignore[arg-type]
    assert [instant.id for instant in chosen] == ["000001"]
    with pytest.raises(ConfigurationError):
        next(recorded_instants(_world(), "guessed"))  # type: ignore[arg-type]
