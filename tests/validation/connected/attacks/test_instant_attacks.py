"""Attacks on one of several scans: what is put there, what is taken away, and where."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

import numpy as np
import pytest

from avsec_gym.attacks.object_scan import ObjectScan
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.registry import Kind, make, names
from avsec_gym.validation.connected.attacks.attacked_instant import (
    AttackedInstant,
    InstantAttack,
)
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.attacks.seen_objects import seen_objects
from avsec_gym.validation.connected.attacks.several_victims import (
    attack_several,
    with_the_same_ghost,
)
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from avsec_gym.world.export.instants import ConnectedInstant, SensorVehicle, WorldObject
from tests.strange_values import STRANGE

_CAR = (14.0, 3.0, 0.1)


@pytest.fixture(scope="module")
def instant(street: Callable[..., list[VehicleScan]]) -> RecordedInstant:
    """Three vehicles that see one car; nothing is labelled."""
    return RecordedInstant("000003", tuple(street((_CAR,), (_CAR,), (_CAR,))))


def _done(attacked: AttackedInstant | None) -> AttackedInstant:
    assert attacked is not None
    return attacked


@pytest.mark.parametrize("name", names(Kind.CONNECTED_ATTACK))
def test_an_attack_changes_the_victims_scan_alone_and_repeats(
    name: str, instant: RecordedInstant
) -> None:
    attack: InstantAttack = make(Kind.CONNECTED_ATTACK, {"name": name, "vehicle": 1})
    first, again = _done(attack.attack(instant, 5)), _done(attack.attack(instant, 5))
    assert first.victim == 1
    assert first.points > 0
    for vehicle in (0, 2):
        assert first.instant.scans[vehicle] is instant.scans[vehicle]
    np.testing.assert_array_equal(first.instant.scans[1].points, again.instant.scans[1].points)
    assert len(first.instant.scans[1].points) != len(instant.scans[1].points)


def test_a_ghost_stands_on_free_ground_and_faces_its_victim(instant: RecordedInstant) -> None:
    for seed in range(8):
        attacked = _done(PastedObject(vehicle=0).attack(instant, seed))
        before, after = (each.scans[0].points for each in (instant, attacked.instant))
        bogus = after[len(before) :]
        assert len(bogus) == attacked.points
        inside = attacked.box.grown(0.3, 0.3).contains(
            0, instant.scans[0].pose[:3, 3] + bogus[:, :3]
        )
        assert inside.all()
        # No object there, and the ground below it at height 0.
        away = np.hypot(*(attacked.box.centre[0, :2] - _CAR[:2]))
        assert away > 2.0
        assert attacked.box.centre[0, 2] == pytest.approx(0.0, abs=0.1)
        # Nothing of it is farther away than its middle by half of its length.
        near = np.linalg.norm(bogus[:, :2], axis=1).mean()
        assert near < np.linalg.norm(attacked.box.centre[0, :2])


def test_a_removed_object_has_no_points_left(instant: RecordedInstant) -> None:
    for rays in ("lost", "pushed"):
        attacked = _done(RemovedObject(vehicle=0, rays=rays).attack(instant))  # type: ignore[arg-type]
        left = attacked.instant.scans[0].in_world()
        inside = attacked.box.contains(0, left) & (left[:, 2] > 0.2)
        assert not inside.any()
        lost = len(instant.scans[0].points) - len(attacked.instant.scans[0].points)
        assert lost == attacked.points if rays == "lost" else lost < attacked.points


def test_a_ghost_in_a_rolling_scan_stands_still(instant: RecordedInstant) -> None:
    clean, sweep = instant.scans[0], RollingSweep(20.0, 0.1)
    rolled = sweep.rolled(clean.points[:, :3].astype(float))
    points = np.c_[rolled, clean.points[:, 3]].astype(np.float32)
    scans = (VehicleScan(points, clean.pose, 0.0, sweep), *instant.scans[1:])
    attacked = _done(PastedObject(vehicle=0).attack(RecordedInstant("a", scans), 2))
    ghost = attacked.instant.scans[0].in_world()[len(points) :]
    assert attacked.box.grown(0.1, 0.1).contains(0, ghost).all()


def test_without_labels_what_looks_like_objects_is_seen(instant: RecordedInstant) -> None:
    [seen] = seen_objects(instant, 0, fewest=50)
    assert np.hypot(*(seen.pose[:2, 3] - _CAR[:2])) < 0.5


def test_several_victims_are_attacked_one_after_the_other(instant: RecordedInstant) -> None:
    done = attack_several(instant, [PastedObject(vehicle=0), RemovedObject(vehicle=2)], 4)
    assert [(each.victim, each.kind) for each in done] == [(0, "ghost"), (2, "removal")]
    scans = done[-1].instant.scans
    assert scans[0] is done[0].instant.scans[0]
    assert scans[1] is instant.scans[1]
    assert len(scans[2].points) != len(instant.scans[2].points)


def test_one_ghost_stands_at_one_place_in_two_scans(instant: RecordedInstant) -> None:
    first = _done(PastedObject(vehicle=0).attack(instant, 4))
    both = with_the_same_ghost(first, 1)
    assert (both.victim, both.box) == (1, first.box)
    for vehicle in (0, 1):
        ghost = both.instant.scans[vehicle].in_world()[-first.points :]
        assert first.box.grown(0.3, 0.3).contains(0, ghost).all()
    for vehicle in (0, 3):
        with pytest.raises(ConfigurationError, match="goes to another vehicle"):
            with_the_same_ghost(first, vehicle)


def test_nothing_to_attack_is_none_and_bad_numbers_are_named() -> None:
    empty = VehicleScan(np.zeros((0, 4), np.float32), np.eye(4))
    nothing = RecordedInstant("000000", (empty, empty))
    assert PastedObject().attack(nothing) is None
    assert RemovedObject().attack(nothing) is None
    with pytest.raises(ConfigurationError, match="no vehicle 7"):
        RemovedObject(vehicle=7).attack(nothing)
    with pytest.raises(ConfigurationError, match=r"from 0\.1 to 60"):
        PastedObject(distance=(5.0, 90.0))
    with pytest.raises(ConfigurationError, match="Known: lost, pushed"):
        RemovedObject(rays="burnt")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("attack", "argument"),
    [
        (kind, each.name)
        for kind in (PastedObject, RemovedObject)
        for each in fields(kind)
        if each.init
    ],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_anything_given_for_an_argument_attacks_or_is_refused_when_it_is_made(
    attack: type[PastedObject | RemovedObject], argument: str, instant: RecordedInstant
) -> None:
    made = 0
    for value in STRANGE:
        try:
            ready = attack(**{argument: value})
        except (ConfigurationError, DataError):
            continue
        made += 1
        try:
            ready.attack(instant)
        except ConfigurationError as error:
            assert argument == "vehicle", value
            assert "there is no vehicle" in str(error)  # noqa: PT017
    # No strange value is the name of a kind of place.
    assert (made > 0) is (argument != "where")
    assert made < len(STRANGE) / 2


def test_no_ghost_stands_around_the_lidar(instant: RecordedInstant) -> None:
    tall = ObjectScan(np.array([[-2, 0, 0.5, 0.3]], np.float32), (3.0, 1.8, 4.2), (-10.0, 0.0))
    for seed in range(5):
        near = PastedObject(vehicle=0, distance=(1.0, 1.0), scan=tall)
        assert near.attack(instant, seed) is None


def _ghost_at(x: float, y: float, height: float = 1.5) -> PastedObject:
    """A ghost of a car exactly there, of the first vehicle, which stands at the origin."""
    distance = float(np.hypot(x, y))
    one = np.array([[-2.0, 0.0, 0.5, 0.3]], np.float32)
    scan = ObjectScan(one, (height, 1.8, 4.2), (-10.0, 0.0))
    return PastedObject(0, (distance, distance), float(np.arctan2(y, x)), scan)


def test_no_ghost_stands_where_another_vehicle_sees_something(
    street: Callable[..., list[VehicleScan]],
) -> None:
    for of_others, free in (((), True), ((_CAR,), False)):
        # From the first vehicle the car is hidden.
        scans = street((), of_others, of_others)
        attacked = _ghost_at(*_CAR[:2]).attack(RecordedInstant("a", tuple(scans)))
        assert (attacked is not None) is free


def test_no_ghost_stands_on_a_labelled_object_that_none_sees(
    street: Callable[..., list[VehicleScan]],
) -> None:
    scans = tuple(street((), (), ()))
    vehicles = tuple(SensorVehicle(number, 0.0, 0.0, 0.0) for number in range(3))
    x, y, heading = _CAR
    car = WorldObject(
        9, "Car", (x, y, 0.0), heading, (1.5, 1.8, 4.2), 0.0, 0.0, moving=False, points=(0, 0, 0)
    )
    for objects, free in (((), True), ((car,), False)):
        truth = ConnectedInstant(0, 0, vehicles, objects)
        attacked = _ghost_at(*_CAR[:2]).attack(RecordedInstant("a", scans, truth))
        assert (attacked is not None) is free


def test_no_ghost_stands_around_the_lidar_of_another_vehicle(
    street: Callable[..., list[VehicleScan]],
) -> None:
    scans = tuple(street((), (), ()))
    x, y = scans[2].pose[:2, 3]
    for farther, free in ((1.0, False), (1.5, True)):
        attack = _ghost_at(farther * x, farther * y, height=3.0)
        assert (attack.attack(RecordedInstant("a", scans)) is not None) is free


def test_what_was_removed_and_how_far_it_was_is_known(
    street: Callable[..., list[VehicleScan]],
) -> None:
    x, y, heading = _CAR
    vehicles = tuple(SensorVehicle(number, 0.0, 0.0, 0.0) for number in range(3))
    van = WorldObject(
        9, "Van", (x, y, 0.0), heading, (1.5, 1.8, 4.2), 0.0, 0.0, moving=False, points=(99, 99, 99)
    )
    scans = tuple(street((_CAR,), (_CAR,), (_CAR,)))
    labelled = RecordedInstant("a", scans, ConnectedInstant(0, 0, vehicles, (van,)))
    attacked = _done(RemovedObject(vehicle=0).attack(labelled))
    assert attacked.category == "Van"
    assert attacked.distance == pytest.approx(np.hypot(x, y), abs=0.01)
    unlabelled = _done(RemovedObject(vehicle=0).attack(RecordedInstant("a", scans)))
    assert unlabelled.category == ""
