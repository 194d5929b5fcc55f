from __future__ import annotations

import numpy as np

from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.closed_loop.recorded.corridor import LEFT, OWN, RIGHT, centre_of, corridor
from avsec_gym.scenario.intention import Intention

ARC = 40.0 * np.column_stack([np.sin(np.linspace(0, 1, 81)), 1 - np.cos(np.linspace(0, 1, 81))])


def test_the_middle_lane_follows_the_path_and_goes_on_straight() -> None:
    lanes = Lanes(corridor(ARC))
    line = lanes.line(OWN)
    away = [abs(line.coordinates(x, y)[1]) for x, y in ARC.tolist()]
    assert max(away) < 0.3
    assert line.length > 40.0 + 60.0 + 200.0
    assert abs(line.heading(line.length) - 1.0) < 0.05


def test_lanes_are_as_wide_as_the_thesis_has_them() -> None:
    lanes = Lanes(corridor(ARC))
    assert all(abs(lanes.width(lane) - 3.5) < 0.01 for lane in (OWN, LEFT, RIGHT))
    assert lanes.intentions(OWN) == tuple(Intention)
    assert lanes.at(0.0, 3.5, 0.0) == LEFT
    assert lanes.at(0.0, -3.5, 0.0) == RIGHT


def test_a_lane_against_the_path_leads_the_other_way() -> None:
    lanes = Lanes(corridor(ARC, against=frozenset({LEFT})))
    assert lanes.intentions(OWN) == (Intention.STRAIGHT, Intention.RIGHT)
    assert abs(abs(lanes.line(LEFT).heading(300.0)) - np.pi) < 0.1
    assert lanes.beside(LEFT, Intention.LEFT) is None


def test_a_car_that_stays_has_a_straight_road() -> None:
    line = centre_of(np.zeros((81, 2)))
    assert abs(line.heading(100.0)) < 1e-9
