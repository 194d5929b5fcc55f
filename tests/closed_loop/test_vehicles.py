"""The vehicles of the loop."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from highway_env.road.road import Road as HighwayRoad

from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.closed_loop.road_network import network_of
from avsec_gym.closed_loop.tracks import STEP, Tracks
from avsec_gym.closed_loop.vehicles import Car, ReactingVehicle, RecordedVehicle
from avsec_gym.planners.vehicle import BMW_320I, simulate
from avsec_gym.scenario.road import Road, straight_lanes


@pytest.fixture
def road() -> HighwayRoad:
    return HighwayRoad(network_of(Lanes(Road(straight_lanes(3, start=-50, end=500)))))


@pytest.mark.parametrize("speed", [6.0, 11.3])
@pytest.mark.parametrize("braking", [3.0, 8.0])
def test_a_car_that_brakes_stops_after_half_of_v_squared_by_a(
    road: HighwayRoad, speed: float, braking: float
) -> None:
    car = Car(road, [0.0, 0.0], 0.0, speed)
    for _ in range(100):
        car.act({"steering": 0.0, "acceleration": -braking})
        car.step(0.05)
    assert car.speed == 0.0
    assert car.position[0] == pytest.approx(speed**2 / (2 * braking), abs=1e-6)


def test_a_car_drives_as_the_planners_model_does(road: HighwayRoad) -> None:
    """Held against the integrator that makes motion primitives."""
    steering, acceleration, rate = 0.15, 1.5, 0.3
    begin = np.array([-BMW_320I.rear_axle, 0.0, 8.0, 0.0, steering])
    expected = simulate(BMW_320I, begin, np.array(acceleration), np.array(-rate), 5, 0.1)[-1]
    car = Car(road, [0.0, 0.0], 0.0, 8.0)
    car.steering_angle = -steering
    for _ in range(5):
        car.act({"steering": car.steering_angle + rate * 0.1, "acceleration": acceleration})
        for _ in range(2):
            car.step(0.05)
    x, y, heading = car.position[0], -car.position[1], -car.heading
    rear = (x - BMW_320I.rear_axle * np.cos(heading), y - BMW_320I.rear_axle * np.sin(heading))
    np.testing.assert_allclose(rear, expected[:2], atol=1e-4)
    assert car.speed == pytest.approx(expected[2])
    assert heading == pytest.approx(expected[3], abs=1e-5)


def test_wheels_turn_at_the_vehicles_rate(road: HighwayRoad) -> None:
    car = Car(road, [0.0, 0.0], 0.0, 5.0)
    car.act({"steering": 0.7, "acceleration": 0.0})
    car.step(0.5)
    assert car.steering_angle == pytest.approx(0.5 * BMW_320I.max_steering_rate)


def recorded() -> Tracks:
    """One actor that swings from lane to lane, recorded from step 3 to step 40."""
    rng = np.random.default_rng(0)
    time = STEP * np.arange(50)
    poses = np.column_stack([7.0 * time, 2.0 * np.sin(time), 0.2 * np.cos(time)])
    poses += 0.05 * rng.standard_normal(poses.shape)
    return Tracks(
        ids=np.array([17]),
        categories=np.array(["Car"]),
        dimensions=np.array([[1.5, 1.8, 4.2]]),
        poses=poses[None],
        speeds=np.full((1, 50), 7.0),
        first=np.array([3]),
        last=np.array([40]),
        below=np.array([1.65]),
    )


def test_a_recorded_actor_is_where_it_was_recorded(road: HighwayRoad) -> None:
    tracks = recorded()
    vehicle = RecordedVehicle(tracks, 0, road, 0.3)
    road.vehicles = [vehicle]
    for step in range(3, 41):
        own = np.array([vehicle.position[0], -vehicle.position[1], -vehicle.heading])
        np.testing.assert_allclose(own, tracks.poses[0, step], atol=0.01)
        for _ in range(2):
            road.act()
            road.step(0.05)
    assert vehicle.LENGTH == 4.2
    assert vehicle.actor == 17


def test_an_actor_is_there_while_it_was_recorded() -> None:
    tracks = recorded()
    there = [tracks.present(0, time) for time in (0.0, 0.2, 0.3, 4.0, 4.05, 4.1)]
    assert there == [False, False, True, True, False, False]


def test_a_reacting_vehicle_stops_behind_what_stands(road: HighwayRoad) -> None:
    tracks = Tracks.at_constant_velocity(
        np.array(["Car", "Car"]),
        np.array([[1.5, 1.8, 4.2]] * 2),
        np.array([[0.0, 0.0, 0.0], [60.0, 0.0, 0.0]]),
        np.array([10.0, 0.0]),
        np.array([1.65, 1.65]),
        300,
    )
    vehicles: list[Any] = [ReactingVehicle(tracks, 0, road), RecordedVehicle(tracks, 1, road)]
    # Lanes on both sides are blocked as well.
    road.vehicles = vehicles
    vehicles[0].enable_lane_change = False
    for _ in range(400):
        road.act()
        road.step(0.05)
    assert vehicles[0].speed < 0.5
    assert 40.0 < vehicles[0].position[0] < 60.0 - 4.2
    assert not vehicles[0].crashed
