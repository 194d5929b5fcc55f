from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from avsec_gym.closed_loop.loop_scenes import loop_scenes
from avsec_gym.closed_loop.tracks import Tracks
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.closed_loop.unavoidable import core, unavoidable
from avsec_gym.closed_loop.vehicles import Car
from avsec_gym.geometry import rectangle_polygons
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.planning_scenario import EgoState


def scene_with_car_at(gap: float, speed: float = 0.0) -> TrafficScene:
    """A street on which a car stands, or drives on, so far from the front bumper."""
    scene = loop_scenes("layouts", count=1).scene("street-000000")
    x = gap + 0.5 * BMW_320I.length + 2.0
    tracks = Tracks.at_constant_velocity(
        np.array(["Car"]),
        np.array([[1.5, 1.8, 4.0]]),
        np.array([[x, 0.0, 0.0]]),
        np.array([speed]),
        np.array([1.65]),
        100,
    )
    return replace(scene, start=EgoState(velocity=10.0), tracks=tracks)


def test_a_car_a_metre_ahead_cannot_be_avoided_and_one_that_leaves_room_can() -> None:
    found = unavoidable(scene_with_car_at(1.0))
    assert found is not None
    assert found.time < 0.2
    # Full braking from 10 m/s takes 6.25 m.
    assert unavoidable(scene_with_car_at(6.3)) is None
    assert unavoidable(scene_with_car_at(1.0, speed=12.0)) is None


@pytest.mark.parametrize("seed", range(20))
def test_whatever_a_car_does_it_covers_its_core(seed: int) -> None:
    generator = np.random.default_rng(seed)
    speed = float(generator.uniform(3.0, 15.0))
    car = Car(None, [0.0, 0.0], 0.0, speed)
    for step in range(1, 12):
        action = {
            "acceleration": float(generator.choice([-8.0, 0.0, 8.0])),
            "steering": float(generator.choice([-0.7, 0.7])) if seed % 2 else 0.7,
        }
        car.act(action)
        car.step(0.05)
        area = core(EgoState(velocity=speed), 0.05 * step)
        if area is None:
            break
        pose = np.array([car.position[0], -car.position[1], -car.heading])
        own = rectangle_polygons(pose[None], BMW_320I.length, BMW_320I.width)[0]
        assert shapely.covers(own.buffer(0.02), area)
    assert step > 3


@pytest.mark.parametrize("id", ["street-000024", "street-000095"])
def test_where_a_layout_ends_at_fault_under_truth_no_car_could_have_avoided_it(id: str) -> None:
    """In both a pedestrian crosses at 7 m/s, a metre before the bumper."""
    assert unavoidable(loop_scenes("layouts", count=100).scene(id)) is not None
