"""Bounds of where a vehicle can be: wide enough for all that is driven, and made where they pay."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.planners import reachability
from avsec_gym.planners.primitives import MotionPrimitives, generate_primitives
from avsec_gym.planners.reachability import reach_table

_HORIZON = 15
_SETS = [generate_primitives((6.0, 8.0), steering_angles=5), generate_primitives((4.0, 6.0))]


@pytest.mark.parametrize("primitives", _SETS, ids=["narrow", "wide"])
def test_every_way_lies_within_the_bounds_of_its_class(primitives: MotionPrimitives) -> None:
    arrays, rng = primitives.arrays, np.random.default_rng(0)
    table = reach_table(primitives, _HORIZON)
    assert table.shape == (arrays.end_class.max() + 1, _HORIZON + 1, 6)
    offset = primitives.vehicle.rear_axle
    for _ in range(300):
        # A first primitive of any kind: what may follow it is its class, and places are its own.
        own = int(rng.integers(len(arrays.steps)))
        bounds = table[arrays.end_class[own]]
        x = y = turned = 0.0
        step = 0
        while True:
            own = int(rng.choice(arrays.successors[slice(*arrays.first_successor[own : own + 2])]))
            if step + arrays.steps[own] > _HORIZON:
                break
            for j in range(1, arrays.steps[own] + 1):
                ahead, left, _, turn = arrays.states[own, j, :4]
                px = x + np.cos(turned) * ahead - np.sin(turned) * left
                py = y + np.sin(turned) * ahead + np.cos(turned) * left
                heading = turned + turn
                centre = px + offset * np.cos(heading), py + offset * np.sin(heading)
                low, high = bounds[step + j, [0, 2, 4]], bounds[step + j, [1, 3, 5]]
                there = np.array([*centre, heading])
                assert (low - 1e-9 <= there).all()
                assert (there <= high + 1e-9).all()
            x, y, turned, step = px, py, heading, step + int(arrays.steps[own])


def test_the_bounds_of_the_first_primitive_are_as_narrow_as_they_can_be() -> None:
    primitives = _SETS[0]
    arrays, table = primitives.arrays, reach_table(primitives, _HORIZON)
    offset = primitives.vehicle.rear_axle
    for before in range(len(arrays.steps)):
        following = arrays.successors[slice(*arrays.first_successor[before : before + 2])]
        for j in range(1, int(arrays.steps[following].min()) + 1):
            x, y, _, heading = arrays.states[following, j, :4].T
            places = x + offset * np.cos(heading), y + offset * np.sin(heading), heading
            expected = [bound for each in places for bound in (each.min(), each.max())]
            np.testing.assert_allclose(table[arrays.end_class[before], j], expected, atol=1e-9)


def test_later_bounds_are_not_much_wider_than_what_is_driven() -> None:
    primitives, steps = _SETS[0], 10
    arrays, table = primitives.arrays, reach_table(primitives, _HORIZON)
    assert (arrays.steps == 5).all()
    offset = primitives.vehicle.rear_axle
    for before in range(len(arrays.steps)):
        places = []
        for first in arrays.successors[slice(*arrays.first_successor[before : before + 2])]:
            ahead, left, _, turned = arrays.states[first, 5, :4]
            for then in arrays.successors[slice(*arrays.first_successor[first : first + 2])]:
                x, y, _, turn = arrays.states[then, 5, :4]
                heading = turned + turn
                places.append(
                    (
                        ahead + np.cos(turned) * x - np.sin(turned) * y + offset * np.cos(heading),
                        left + np.sin(turned) * x + np.cos(turned) * y + offset * np.sin(heading),
                    )
                )
        low, high = np.min(places, axis=0), np.max(places, axis=0)
        bounds = table[arrays.end_class[before], steps]
        # Headings are known to half a bin; a primitive leads some 5 m, twice.
        widest = 4 * np.pi / reachability._BINS * 12.0
        assert (low - bounds[[0, 2]] < widest).all()
        assert (bounds[[1, 3]] - high < widest).all()


def test_what_would_take_long_is_not_made(monkeypatch: pytest.MonkeyPatch) -> None:
    reach_table.cache_clear()
    monkeypatch.setattr(reachability, "_LARGEST_WORK", 1000)
    assert reach_table(_SETS[0], _HORIZON).shape == (0, _HORIZON + 1, 6)
    reach_table.cache_clear()
