"""The kernel of a drive: an action held for some instants, and whether the drive ends by it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.angles import wrapped
from avsec_gym.closed_loop.centre_line import coordinates
from avsec_gym.closed_loop.light.car_motion import (
    HEADING,
    X,
    Y,
    drive_on,
    steering_rate,
    touches,
)
from avsec_gym.closed_loop.light.road_table import RoadTable, contains, heading_at
from avsec_gym.closed_loop.light.traffic_table import TrafficTable
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel

DRIVING, COLLISION, OFF_ROAD, GOAL = range(4)
"""How things stand after an instant."""


class Aim(NamedTuple):
    """Where a drive is to lead, and where it began."""

    lane: int
    """Row of the intended lane."""
    from_: float
    """Where along that lane's line the start lies, metres."""
    distance: float
    """Metres from there to the goal."""
    start_lane: int
    """Row of the lane that progress is counted along."""
    start: float
    """Where along that lane's line the start lies, metres."""


class Reached(NamedTuple):
    """Where an action has led."""

    frame: int
    """The last instant."""
    ending: int
    """How things stand."""
    path: float
    """Metres driven."""
    progress: float
    """Metres along the road since the start of the drive."""
    crashed: bool
    """Whether highway-env would call the car crashed: it has touched any actor at all."""


@kernel(nogil=True)
def advance(
    cars: Floats,
    frame: int,
    count: int,
    acceleration: float,
    steering: float,
    dt: float,
    aim: Aim,
    excused: NDArray[np.bool_],
    road: RoadTable,
    traffic: TrafficTable,
) -> Reached:
    """Drive on, up to the first instant that ends the drive.

    Args:
        cars: The car's state at every instant, shape (F, 5); what follows `frame` is written.
        frame: The present instant.
        count: Instants that the action is held for.
        acceleration: The car's acceleration, m/s2.
        steering: Angle that the wheels turn to, rad, positive to the left.
        dt: Seconds between two instants.
        aim: Goal and start.
        excused: The actors that have been touched from the start on, which is no collision, shape
            (N,); those that are touched no more are taken out.
        road: The road.
        traffic: The traffic.
    """
    rate = steering_rate(cars[frame], steering)
    # Invariant: rows up to `frame` are written, and none of the instants so far ends the drive.
    ending, path, crashed = DRIVING, 0.0, False
    for _ in range(count):
        # Where the car comes to.
        drive_on(cars[frame], acceleration, steering, rate, dt, cars[frame + 1])
        frame += 1
        car = cars[frame]
        path += np.hypot(car[X] - cars[frame - 1, X], car[Y] - cars[frame - 1, Y])
        # What it touches: highway-env looks at those who were there before.
        for i in range(len(traffic.sizes)):
            here, before = traffic.present[frame, i], traffic.present[frame - 1, i]
            touching = False
            if (here or before) and touches(car, traffic.poses[frame, i], traffic.sizes[i]):
                crashed, touching = crashed or before, here
            if touching and not excused[i]:
                ending = COLLISION
            excused[i] = excused[i] and touching
        # Whether it has left the road, or come to its goal.
        if ending == DRIVING and not contains(road.edges, car[X], car[Y]):
            ending = OFF_ROAD
        if ending == DRIVING and _reaches(road, aim, car):
            ending = GOAL
        if ending != DRIVING:
            break
    # How far it is along the lane that it began in.
    begin, end = road.lines[aim.start_lane, 0], road.lines[aim.start_lane, 1]
    along, _ = coordinates(road.points, begin, end, cars[frame, X], cars[frame, Y])
    return Reached(frame, ending, path, along - aim.start, crashed)


@kernel(nogil=True)
def _reaches(road: RoadTable, aim: Aim, car: Floats) -> bool:
    """`reaches_goal`: far enough along the intended lane, within it, and along it."""
    begin, end = road.lines[aim.lane, 0], road.lines[aim.lane, 1]
    along, left = coordinates(road.points, begin, end, car[X], car[Y])
    if along - aim.from_ < aim.distance or abs(left) > 0.5 * road.widths[aim.lane]:
        return False
    return bool(abs(wrapped(car[HEADING] - heading_at(road.points, begin, end, along))) < 0.5)
