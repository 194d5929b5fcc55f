"""A ghost that lasts: its motion by finite differences of where it stands."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.commands.attacked_drives import AttackedDrives
from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant, LastingAttack
from avsec_gym.validation.connected.attacks.moving_ghost import MovingGhost
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import pose_at, scan_of

_CAR, _SPEED, _STEP, _HEADING = (14.0, 9.0, 0.1), 6.0, 0.1, 0.2
_AHEAD = np.array([np.cos(_HEADING), np.sin(_HEADING)])


@pytest.fixture(scope="module")
def drive() -> list[RecordedInstant]:
    """Five instants: vehicle 0 drives, vehicle 1 stands."""
    instants = []
    for frame in range(5):
        place = _SPEED * _STEP * frame * _AHEAD
        pose = pose_at(*place, _HEADING)
        clean = scan_of(pose, _CAR)
        sweep = RollingSweep(_SPEED, 0.0)
        rolled = sweep.rolled(clean.points[:, :3].astype(float))
        points = np.c_[rolled, clean.points[:, 3]].astype(np.float32)
        moving = VehicleScan(points, pose, 0.0, sweep)
        scans = (moving, scan_of(pose_at(30, 2, np.pi), _CAR))
        instants.append(RecordedInstant(f"drive/{frame:06d}", scans))
    return instants


def _all(attacks: AttackedDrives, drive: list[RecordedInstant]) -> list[AttackedInstant]:
    found = []
    for number, instant in enumerate(drive):
        attacks.show(instant, number, "drive")
        attacked = attacks.attacked(instant, number)
        assert attacked is not None
        found.append(attacked)
    return found


@pytest.mark.parametrize("speed", [None, 11.0, 0.0])
def test_it_moves_evenly_where_its_victim_headed(
    speed: float | None, drive: list[RecordedInstant]
) -> None:
    found = _all(AttackedDrives(MovingGhost(vehicle=0, speed=speed), 3), drive)
    places = np.array([each.box.centre[0] for each in found])
    velocity = np.diff(places[:, :2], axis=0) / _STEP
    expected = (_SPEED if speed is None else speed) * _AHEAD
    np.testing.assert_allclose(velocity, np.tile(expected, (4, 1)), atol=1e-6)
    # On the ground, with the same size and heading throughout.
    np.testing.assert_allclose(places[:, 2], 0.0, atol=0.1)
    for each in found:
        np.testing.assert_allclose(each.box.heading, found[0].box.heading, atol=1e-9)
        np.testing.assert_array_equal(each.box.size, found[0].box.size)
        # Its points are where its box is, in the world.
        ghost = each.instant.scans[0].in_world()[-each.points :]
        assert each.box.grown(0.2, 0.2).contains(0, ghost).all()


def test_with_its_victims_speed_it_stays_as_far_ahead(drive: list[RecordedInstant]) -> None:
    found = _all(AttackedDrives(MovingGhost(vehicle=0), 3), drive)
    away = [
        np.linalg.norm(each.box.centre[0, :2] - each.instant.scans[0].pose[:2, 3]) for each in found
    ]
    np.testing.assert_allclose(away, away[0], atol=1e-6)


def test_a_run_that_goes_on_has_the_same_ghost(drive: list[RecordedInstant]) -> None:
    whole = _all(AttackedDrives(MovingGhost(vehicle=0), 3), drive)
    resumed = AttackedDrives(MovingGhost(vehicle=0), 3)
    for number, instant in enumerate(drive):
        resumed.show(instant, number, "drive")
    again = resumed.attacked(drive[4], 4)
    assert again is not None
    np.testing.assert_array_equal(again.instant.scans[0].points, whole[4].instant.scans[0].points)
    # Another drive has a ghost of its own.
    resumed.show(drive[4], 5, "another")
    other = resumed.attacked(drive[4], 5)
    assert other is not None
    assert np.abs(other.box.centre - again.box.centre).max() > 0.1


def test_other_attacks_begin_anew_at_each_instant(drive: list[RecordedInstant]) -> None:
    paste = PastedObject(vehicle=0)
    assert not isinstance(paste, LastingAttack)
    assert isinstance(MovingGhost(), LastingAttack)
    attacks = AttackedDrives(paste, 3)
    attacks.show(drive[1], 1, "drive")
    found, own = attacks.attacked(drive[1], 1), paste.attack(drive[1], (3, 1))
    assert found is not None
    assert own is not None
    np.testing.assert_array_equal(found.instant.scans[0].points, own.instant.scans[0].points)


def test_it_ends_where_the_victim_drives_into_it(drive: list[RecordedInstant]) -> None:
    begun = MovingGhost(vehicle=0, speed=0.0, distance=(8.0, 9.0)).begin(drive[0], 3)
    assert begun is not None
    there = begun.in_world[:2, 3]
    inside = pose_at(*there, _HEADING)
    scan = VehicleScan(drive[0].scans[0].points, inside, 0.0)
    assert begun.attack(RecordedInstant("x", (scan, drive[0].scans[1])), 1.0) is None


@pytest.mark.parametrize("wrong", [{"speed": -1.0}, {"step": 0.0}, {"where": "roof"}])
def test_what_cannot_be_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ConfigurationError):
        MovingGhost(**wrong)  # type: ignore[arg-type]
