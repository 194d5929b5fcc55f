"""The road that most vehicles play tracks on, held against highway-env's own."""

from __future__ import annotations

import numpy as np
import pytest
from highway_env.road.road import Road as HighwayRoad

from avsec_gym.closed_loop.loop_road import LoopRoad
from avsec_gym.closed_loop.reacting import Reacting
from avsec_gym.closed_loop.road_network import network_of
from avsec_gym.closed_loop.traffic import RoadTraffic
from avsec_gym.closed_loop.traffic_scene import TrafficScene, scene_on_straight_lanes
from avsec_gym.closed_loop.vehicles import Car
from avsec_gym.scenario.scene_sets import scene_set


def crashes(kind: type[HighwayRoad], scene: TrafficScene, share: float) -> np.ndarray:
    """Places and crashes of all vehicles over two seconds of a car that drives straight on."""
    road = kind(network=network_of(scene.lanes), np_random=np.random.RandomState(0))
    car = Car(road, [scene.start.x, -scene.start.y], 0.0, 2 * scene.start.velocity)
    road.vehicles = [car]
    traffic = RoadTraffic(scene, road, Reacting(share))
    rows = []
    for step in range(40):
        road.act()
        traffic.step_absent(0.05)
        road.step(0.05)
        traffic.show(0.05 * (step + 1))
        rows.append([(*v.position, v.heading, v.crashed) for v in (car, *traffic.actors)])
    return np.array(rows)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_the_same_vehicles_crash(share: float) -> None:
    crashed = 0
    for number, scene in enumerate(scene_set("layouts", count=12).scenes):
        drive = scene_on_straight_lanes(scene)
        one, other = (crashes(kind, drive, share) for kind in (LoopRoad, HighwayRoad))
        np.testing.assert_array_equal(one, other, err_msg=str(number))
        crashed += int(one[-1, 0, 3])
    assert crashed > 0
