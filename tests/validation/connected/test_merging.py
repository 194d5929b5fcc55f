"""Regions of several vehicles become one set."""

import numpy as np
import pytest

from avsec_gym.validation.connected.merging import merged_regions, regions_in_world
from avsec_gym.validation.connected.regions import Regions


def _cars(*places: tuple[float, float]) -> Regions:
    centre = np.array([[x, y, 0.0] for x, y in places])
    return Regions(centre, np.tile([4.0, 1.8, 1.5], (len(places), 1)), np.zeros(len(places)))


def test_the_box_in_the_middle_stands_for_an_object() -> None:
    merged = merged_regions([_cars((0.0, 0.0)), _cars((0.4, 0.0), (20.0, 0.0)), _cars((0.6, 0.1))])
    assert sorted(merged.centre[:, 0].tolist()) == [0.4, 20.0]
    assert merged.centre[0, 0] == 0.4  # What most agree on stands first.


def test_neighbours_stay_apart() -> None:
    assert len(merged_regions([_cars((0.0, 0.0), (0.0, 2.0), (4.2, 0.0))])) == 3
    assert len(merged_regions([Regions.empty(), Regions.empty()])) == 0


def test_two_vehicles_that_see_one_car_send_one_region() -> None:
    """A car at (10, 5) of the world, seen by a vehicle at the origin and one that faces it."""
    facing = np.array([[-1.0, 0, 0, 20], [0, -1, 0, 5], [0, 0, 1, 0.3], [0, 0, 0, 1]])
    seen_by_it = Regions(
        np.array([[10.0, 0.0, -0.3]]), np.array([[4.0, 1.8, 1.5]]), np.array([np.pi])
    )
    own = regions_in_world(seen_by_it, facing)
    assert own.centre == pytest.approx(np.array([[10.0, 5.0, 0.0]]))
    assert np.cos(own.heading[0]) == pytest.approx(1.0)
    assert len(merged_regions([_cars((10.0, 5.0)), own])) == 1
