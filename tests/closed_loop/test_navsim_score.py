"""The score, held against NAVSIM's public formula by hand, and its parts against physics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import savgol_filter

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
from avsec_gym.geometry import Floats
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


def beside(log: DriveLog, *more: tuple[float, float, float]) -> DriveLog:
    """The same with more actors of 4 x 2 m that stand."""
    steps = len(log.car)
    standing = np.tile(np.array(more), (steps, 1, 1))
    return DriveLog(
        log.dt,
        log.car,
        np.concatenate([log.sizes, np.tile([4.0, 2.0], (len(more), 1))]),
        np.concatenate([log.poses, standing], axis=1),
        np.concatenate([log.speeds, np.zeros((steps, len(more)))], axis=1),
        np.ones((steps, 1 + len(more)), bool),
    )


def test_all_that_touch_at_the_start_are_excused_and_nothing_else() -> None:
    grazed = (0.0, 1.75, 0.0), (0.0, -1.75, 0.0)
    assert first_contact(beside(drive(0.0, (1.0, 0.0, 0.0)), *grazed)) is None
    contact = first_contact(beside(drive(10.0, grazed[0]), grazed[1], (30.0, 0.0, 0.0)))
    assert contact is not None
    assert (contact.step, contact.actor) == (math.ceil(30.0 - 2.0 - BMW_320I.length / 2), 2)


@pytest.mark.parametrize("away", [0.2, 30.0])
def test_a_touch_that_has_ended_is_excused_no_more(away: float) -> None:
    """An actor that reaches into the car goes away, out of all reach or hardly, and comes back."""
    log = drive(0.0, (4.0, 0.0, 0.0))
    assert first_contact(log) is None
    log.poses[5:9, 0, 0] += 2.0 + BMW_320I.length / 2 - 4.0 + away
    contact = first_contact(log)
    assert contact is not None
    assert (contact.step, contact.actor) == (9, 0)
    # Whoever is not there touches nothing.
    log = drive(0.0, (4.0, 0.0, 0.0))
    log.present[5:9] = False
    assert first_contact(log) is not None


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


def test_half_a_second_of_gentle_acceleration_is_comfortable() -> None:
    """Its end is no jerk: between two instants, 1 m/s2 would end with 10 m/s3."""
    log = drive(10.0, (200.0, 3.5, 0.0))
    log.car[:, 2] = 10.0 + np.minimum(0.1 * np.arange(41), 0.5)
    assert is_comfortable(log)


@pytest.mark.parametrize(("steps", "comfortable"), [(3, True), (4, False), (5, False)])
def test_comfort_of_the_shortest_drives(steps: int, comfortable: bool) -> None:
    log = drive(10.0, (200.0, 3.5, 0.0), steps=steps)
    log.car[:, 2] = 20.0 - 6.0 * 0.1 * np.arange(steps)
    assert is_comfortable(log) == comfortable


def recomputed(log: DriveLog) -> bool:
    """NAVSIM's published windows, degrees and bounds, written down once more."""
    v, heading, n = log.car[:, 2], np.unwrap(log.car[:, 3]), len(log.car)
    a = np.gradient(v, 0.1)
    lateral = v * np.gradient(heading, 0.1)
    short, middle, long = min(5, n), min(8, n), min(15, n)

    def jerk(acceleration: Floats) -> Floats:
        smooth = np.round(savgol_filter(acceleration, middle, 2), 8)
        return np.asarray(savgol_filter(smooth, long, 2, deriv=1, delta=0.1))

    bounded = [
        (savgol_filter(a, middle, 2), -4.05, 2.40),
        (savgol_filter(lateral, middle, 2), -4.89, 4.89),
        (jerk(np.hypot(a, lateral)), -8.37, 8.37),
        (jerk(a), -4.13, 4.13),
        (savgol_filter(heading, short, 2, deriv=1, delta=0.1), -0.95, 0.95),
        (savgol_filter(heading, short, 3, deriv=2, delta=0.1), -1.93, 1.93),
    ]
    return all(low < values.min() and values.max() < high for values, low, high in bounded)


def test_comfort_is_what_another_computation_finds() -> None:
    draw, found = np.random.default_rng(5), []
    for _ in range(300):
        steps = int(draw.integers(4, 60))
        log = drive(10.0, (200.0, 3.5, 0.0), steps=steps)
        changes = draw.normal(size=(2, steps)) * 10 ** draw.uniform(-2.0, 0.3, (2, 1))
        smooth = np.cumsum(np.convolve(changes[0], np.ones(3) / 3, "same"))
        log.car[:, 2] = np.maximum(12.0 + draw.uniform(0.1, 0.5) * smooth, 0.0)
        log.car[:, 3] = 3.0 + np.cumsum(0.05 * changes[1])
        log.car[:, 3] = (log.car[:, 3] + np.pi) % (2 * np.pi) - np.pi
        found.append(is_comfortable(log))
        assert found[-1] == recomputed(log)
    assert 30 < sum(found) < 270


def test_corners_off_the_road_are_not_drivable() -> None:
    assert stays_drivable(drive(5.0, (200.0, 0.0, 0.0), y=4.4), DRIVABLE)
    assert not stays_drivable(drive(5.0, (200.0, 0.0, 0.0), y=4.5), DRIVABLE)


def test_progress_is_a_share_of_what_was_to_be_made() -> None:
    assert progress_share(20.0, 40.0) == 0.5
    assert progress_share(50.0, 40.0) == 1.0
    assert progress_share(-3.0, 40.0) == 0.0
    assert progress_share(1.0, 4.0) == 1.0
