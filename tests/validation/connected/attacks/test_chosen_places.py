"""Places in the path and in blind spots, held against shapely and small steps of motion."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from shapely.geometry import LineString, Polygon

from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind, make
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.attacks.chosen_places import (
    other_observers,
    place_in_path,
    telling_rays,
)
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import CARS, POSES, car_regions, scan_of


def _driven(speed: float, turn_rate: float, distance: float) -> np.ndarray:
    """The way of a vehicle by many small steps, shape (steps, 2)."""
    steps = 4000
    seconds = distance / speed / steps
    heading = turn_rate * seconds * (np.arange(steps) + 0.5)
    moves = speed * seconds * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    return np.cumsum(moves, axis=0)


def _outline(box: Regions) -> Polygon:
    cos, sin = np.cos(box.heading[0]), np.sin(box.heading[0])
    corners = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * box.size[0, :2] / 2
    return Polygon(corners @ [[cos, sin], [-sin, cos]] + box.centre[0, :2])


@pytest.mark.parametrize(("speed", "turn_rate"), [(10.0, 0.3), (5.0, -0.4), (20.0, 0.0)])
def test_the_path_is_that_of_small_steps(speed: float, turn_rate: float) -> None:
    place = place_in_path(RollingSweep(speed, turn_rate), 12.0)
    np.testing.assert_allclose(place, _driven(speed, turn_rate, 12.0)[-1], atol=1e-5)


def test_the_path_of_what_stands_is_straight() -> None:
    assert place_in_path(RollingSweep(0.2, 0.4), 12.0) == (12.0, 0.0)


@pytest.mark.parametrize("turn_rate", [0.25, -0.25, 0.0])
def test_a_ghost_in_the_path_would_be_driven_into(turn_rate: float) -> None:
    sweep = RollingSweep(8.0, turn_rate)
    clean = scan_of(POSES[0], (8.0, 9.0, 0.0), (6.0, -9.0, 0.0))
    rolled = sweep.rolled(clean.points[:, :3].astype(float))
    points = np.c_[rolled, clean.points[:, 3]].astype(np.float32)
    instant = RecordedInstant("a", (VehicleScan(points, POSES[0], 0.0, sweep), clean))
    attack = make(Kind.CONNECTED_ATTACK, {"name": "paste_in_path", "vehicle": 0})
    found = [attack.attack(instant, seed) for seed in range(6)]
    way = LineString(np.r_[[[0, 0]], _driven(8.0, turn_rate, 45.0)]).buffer(0.9)
    reached = [each for each in found if each is not None]
    assert len(reached) >= 4
    assert all(_outline(each.box).intersects(way) for each in reached)
    assert all(each.victim == 0 for each in reached)


@pytest.fixture(scope="module")
def street_of_cars() -> RecordedInstant:
    return RecordedInstant("b", tuple(scan_of(pose, *CARS) for pose in POSES))


def test_the_rays_of_others_tell_nothing_of_what_a_car_hides() -> None:
    """A low thing behind a car and one in the open; shapely knows which one the car covers."""
    car = (12.0, 0.0, np.pi / 2)
    instant = RecordedInstant("c", tuple(scan_of(pose, car) for pose in POSES[:2]))
    [other] = other_observers(instant, 1)
    [outline] = [_outline(car_regions(car))]
    for place, hidden in (((14.5, 0.0), True), ((14.5, 9.0), False)):
        sight = LineString([POSES[0][:2, 3], place])
        assert sight.intersects(outline) is hidden
        # Half a metre high: the eye at 1.73 m does not see it over the roof at 1.5 m.
        grid = np.mgrid[-0.3:0.4:0.1, -0.3:0.4:0.1, 0.4:0.7:0.1].reshape(3, -1).T
        world = grid + np.array([*place, 0.0])
        own = (world - POSES[1][:3, 3]) @ POSES[1][:3, :3]
        box = Regions(np.array([[*place, 0.0]]), np.array([[1.0, 1.0, 0.8]]), np.zeros(1))
        told = telling_rays([other], own, box, POSES[1], 0.0)
        assert (told == 0) is hidden


def test_a_blind_spot_tells_the_others_less(street_of_cars: RecordedInstant) -> None:
    observers = other_observers(street_of_cars, 0)

    def told(attacked: AttackedInstant | None) -> int:
        assert attacked is not None
        ghost = attacked.instant.scans[0].points[-attacked.points :, :3].astype(float)
        return telling_rays(observers, ghost, attacked.box, POSES[0], 0.0)

    blind = make(Kind.CONNECTED_ATTACK, {"name": "paste_in_blind_spot", "vehicle": 0})
    anywhere = PastedObject(vehicle=0)
    chosen = [told(blind.attack(street_of_cars, seed)) for seed in range(4)]
    drawn = [told(anywhere.attack(street_of_cars, seed)) for seed in range(4)]
    assert all(least <= some for least, some in zip(chosen, drawn, strict=True))
    assert sum(chosen) < 0.5 * sum(drawn)


def test_a_bearing_is_for_a_place_anywhere(street: Callable[..., list[VehicleScan]]) -> None:
    for where in ("path", "blind_spot"):
        with pytest.raises(ConfigurationError, match="bearing"):
            PastedObject(where=where, bearing=0.0)  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match="where"):
        PastedObject(where="roof")  # type: ignore[arg-type]
