"""The score, held against NAVSIM's public formula by hand, and its parts against physics."""

from __future__ import annotations

import math

import numpy as np
import pytest

from avsec_gym.closed_loop.drive_log import DriveLog, first_contact, smallest_distance
from avsec_gym.closed_loop.fault import at_fault
from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.closed_loop.navsim_score import (
    NavsimScore,
    is_comfortable,
    progress_share,
    stays_drivable,
    time_to_collision,
)
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.road import Road, straight_lanes

ROAD = Road(straight_lanes(3, start=-50, end=300))
LANES, DRIVABLE = Lanes(ROAD), ROAD.area


@pytest.mark.parametrize(
    ("parts", "total"),
    [
        ((1, 1, 1, 1, 1), 1.0),
        ((1, 1, 1, 1, 0), 10 / 12),
        ((1, 1, 0, 0.6, 1), 5 / 12),
        ((0.5, 1, 1, 0.5, 1), 0.5 * 9.5 / 12),
        ((1, 0, 1, 1, 1), 0.0),
        ((0, 1, 1, 1, 1), 0.0),
    ],
)
def test_the_score_is_the_public_formulas(parts: tuple[float, ...], total: float) -> None:
    assert NavsimScore(*parts).total == pytest.approx(total)


def drive(
    speed: float,
    pose: tuple[float, float, float],
    other: float = 0.0,
    steps: int = 41,
    **car: float,
) -> DriveLog:
    """A car along x at a speed, and one actor of 4 x 2 m at constant velocity, for 4 s at 10 Hz."""
    time = 0.1 * np.arange(steps)
    own = np.zeros((steps, 5))
    own[:, 0], own[:, 1], own[:, 2] = speed * time, car.get("y", 0.0), speed
    poses = np.tile(np.array(pose), (steps, 1, 1))
    poses[:, 0, 0] += other * time * math.cos(pose[2])
    poses[:, 0, 1] += other * time * math.sin(pose[2])
    return DriveLog(
        0.1,
        own,
        np.array([[4.0, 2.0]]),
        poses,
        np.full((steps, 1), other),
        np.ones((steps, 1), bool),
    )


def fault(log: DriveLog) -> bool:
    contact = first_contact(log)
    assert contact is not None
    return at_fault(log, contact, LANES, DRIVABLE)


def test_who_drives_into_a_standing_car_is_at_fault() -> None:
    assert fault(drive(10.0, (30.0, 0.0, 0.0)))


def test_who_is_hit_while_standing_or_from_behind_is_not() -> None:
    assert not fault(drive(0.0, (-30.0, 0.0, 0.0), 10.0))
    assert not fault(drive(5.0, (-15.0, 0.0, 0.0), 12.0))


def test_a_side_swipe_is_the_fault_of_who_is_astride() -> None:
    """The other comes from the left at a shallow angle and touches the side."""
    beside = (-1.0, 3.6, -0.15)
    assert not fault(drive(8.0, beside, 9.0))
    assert fault(drive(8.0, (-1.0, 5.35, -0.15), 9.0, y=1.75))


def test_the_first_touch_is_when_the_gap_is_driven() -> None:
    contact = first_contact(drive(10.0, (30.0, 0.0, 0.0)))
    assert contact is not None
    gap = 30.0 - 2.0 - BMW_320I.length / 2
    assert contact.step == math.ceil(gap)


def test_what_touches_at_the_start_is_no_collision_of_the_drive() -> None:
    assert first_contact(drive(0.0, (1.0, 0.0, 0.0))) is None


def test_the_smallest_distance_is_that_beside_the_passed_car() -> None:
    log = drive(10.0, (15.0, 3.5, 0.0))
    assert smallest_distance(log) == pytest.approx(3.5 - 1.0 - BMW_320I.width / 2)


def test_time_to_collision_is_gap_by_closing_speed() -> None:
    log = drive(10.0, (20.0, 0.0, 0.0), steps=2)
    gap = 20.0 - 2.0 - BMW_320I.length / 2
    # Looked at every 0.3 s from the second instant, which is a metre nearer.
    assert time_to_collision(log, LANES, DRIVABLE) == pytest.approx(
        0.3 * math.ceil((gap - 1.0) / 10.0 / 0.3)
    )
    assert time_to_collision(drive(10.0, (20.0, 3.5, 0.0)), LANES, DRIVABLE) == math.inf
    assert time_to_collision(drive(10.0, (30.0, 0.0, 0.0), 10.0), LANES, DRIVABLE) == math.inf


def test_comfort_ends_where_braking_is_hard() -> None:
    time = 0.1 * np.arange(30)
    for braking, comfortable in ((2.0, True), (5.0, False)):
        log = drive(10.0, (200.0, 3.5, 0.0), steps=30)
        log.car[:, 2] = 20.0 - braking * time
        assert is_comfortable(log) == comfortable


def test_corners_off_the_road_are_not_drivable() -> None:
    assert stays_drivable(drive(5.0, (200.0, 0.0, 0.0), y=4.4), DRIVABLE)
    assert not stays_drivable(drive(5.0, (200.0, 0.0, 0.0), y=4.5), DRIVABLE)


def test_progress_is_a_share_of_what_was_to_be_made() -> None:
    assert progress_share(20.0, 40.0) == 0.5
    assert progress_share(50.0, 40.0) == 1.0
    assert progress_share(-3.0, 40.0) == 0.0
    assert progress_share(1.0, 4.0) == 1.0
