"""Which vehicles react, held against what they do on the road."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from highway_env.road.road import Road

from avsec_gym.closed_loop.reacting import Reacting, reacting_of
from avsec_gym.closed_loop.road_network import network_of
from avsec_gym.closed_loop.tracks import Tracks
from avsec_gym.closed_loop.traffic import RoadTraffic
from avsec_gym.closed_loop.traffic_scene import TrafficScene, thesis_road
from avsec_gym.errors import ConfigurationError
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.planning_scenario import EgoState

DRIVERS = 6


def scene(id: str = "row") -> TrafficScene:
    """Cars one behind the other with gaps of 2 m, and a parked one that stands in the way."""
    places = [*np.arange(DRIVERS) * 6.0, DRIVERS * 6.0 + 4.0]
    tracks = Tracks.at_constant_velocity(
        np.full(len(places), "Car"),
        np.tile([1.5, 1.7, 4.0], (len(places), 1)),
        np.array([(x, 0.0, 0.0) for x in places]),
        np.array([8.0] * DRIVERS + [0.0]),
        np.full(len(places), 1.65),
        300,
    )
    start = EgoState(-50.0, 0.0, 6.0, 0.0, 0.0)
    return TrafficScene(id, thesis_road(), RoadType.STREET, start, tracks, (6.0, 8.0))


def slowed(reacting: Reacting, id: str = "row") -> set[int]:
    """Ids of those that have not kept the speed of their tracks after a second."""
    row = scene(id)
    road = Road(network=network_of(row.lanes), np_random=np.random.RandomState(0))
    traffic = RoadTraffic(row, road, reacting)
    for step in range(20):
        road.act()
        traffic.step_absent(0.05)
        road.step(0.05)
        traffic.show(0.05 * (step + 1))
    wanted = np.array([8.0] * DRIVERS + [0.0])
    return set(row.tracks.ids[np.abs(traffic.speeds() - wanted) > 0.1].tolist())


def test_all_that_drive_react_or_none() -> None:
    drivers = set(scene().tracks.ids[:DRIVERS].tolist())
    assert slowed(reacting_of("recorded")) == set()
    assert slowed(reacting_of("reacting")) == drivers


def test_those_that_are_named_react_and_a_parked_one_does_not() -> None:
    ids = scene().tracks.ids.tolist()
    assert slowed(reacting_of({"name": "reacting", "ids": [ids[1], ids[4], ids[-1], 999]})) == {
        ids[1],
        ids[4],
    }


def test_a_share_is_so_many_and_the_same_ones_again() -> None:
    half = slowed(reacting_of({"name": "reacting", "share": 0.5}))
    assert len(half) == 3
    assert half == slowed(reacting_of({"name": "reacting", "share": 0.5}))
    assert half < slowed(reacting_of({"name": "reacting", "share": 0.8}))
    chosen = {Reacting(0.5).chosen(str(i), np.arange(DRIVERS)) for i in range(20)}
    assert len(chosen) > 5, "which ones depends on the scene"


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("reactng", 'mean "reacting"'),
        ({"name": "reacting", "shar": 0.5}, 'mean "share"'),
        ({"name": "recorded", "share": 0.5}, "no argument 'share'"),
        ({"name": "reacting", "share": 0.5, "ids": [1]}, "give one"),
        ({"name": "reacting", "ids": "all"}, "ids in traffic"),
        ({"name": "reacting", "share": 1.5}, "share of traffic that reacts.*from 0 to 1"),
        ({"name": "reacting", "ids": [-1]}, "an actor's id"),
        ({"name": "reacting", "share": "all"}, "share of traffic"),
        ({}, "traffic"),
        (5, "traffic"),
    ],
)
def test_what_chooses_nothing_is_refused(wrong: Any, message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        reacting_of(wrong)
