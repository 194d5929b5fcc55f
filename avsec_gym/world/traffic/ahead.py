"""Who is in whose way: the strongest interaction with anything in the corridor ahead."""

from __future__ import annotations

import numpy as np
from numba import njit

from avsec_gym.geometry import Floats
from avsec_gym.world.traffic.driving import calm_interaction
from avsec_gym.world.traffic.routes import SPACING
from avsec_gym.world.traffic.state import NARROW, Network, Traffic

_SIDE = 0.2
"""Room that vehicles leave beside each other, metres."""
_SIDE_OF_PEOPLE = 0.3
"""Room that vehicles leave beside cyclists and people."""
_SIDE_AMONG_PEOPLE = 0.1
_FARTHEST = 150.0
_BEHIND = 8.0
"""Metres."""
_BESIDE = 1.0
"""What is less than this behind one's front is still ahead, metres."""


@njit(cache=True)
def interactions_ahead(network: Network, traffic: Traffic) -> Floats:
    """Strongest `calm_interaction` of each with another that is in the way, shape (N,).

    A footprint is a row of discs as wide as it; the corridor is the stretch of the route ahead,
    with the sideways motion still to come.
    """
    count = len(traffic.place)
    strongest = np.zeros(count)
    for one in range(count):
        speed = traffic.speed[one]
        horizon = min(4.0 + 2.0 * speed + speed * speed / 2.6, _FARTHEST)
        for other in range(count):
            if other == one:
                continue
            apart_x = traffic.poses[other, 0] - traffic.poses[one, 0]
            apart_y = traffic.poses[other, 1] - traffic.poses[one, 1]
            reach = horizon + 0.5 * traffic.length[one] + traffic.length[other]
            squared = apart_x * apart_x + apart_y * apart_y
            if squared > reach * reach:
                continue
            forward = apart_x * np.cos(traffic.poses[one, 2])
            forward += apart_y * np.sin(traffic.poses[one, 2])
            # No turn leads back to what is far behind.
            if forward < -_BEHIND - 0.5 * traffic.length[other]:
                continue
            gap, heading = _gap(network, traffic, one, other, horizon)
            if gap < horizon:
                theirs = traffic.speed[other] * np.cos(traffic.poses[other, 2] - heading)
                felt = calm_interaction(
                    speed,
                    gap,
                    speed - max(theirs, 0.0),
                    traffic.manners.headway[one],
                    traffic.manners.standstill[one],
                    traffic.manners.acceleration[one],
                    traffic.manners.braking[one],
                )
                strongest[one] = max(strongest[one], felt)
    return strongest


@njit(cache=True)
def _gap(
    network: Network, traffic: Traffic, one: int, other: int, horizon: float
) -> tuple[float, float]:
    """Free metres on the route to another's footprint, and the route's heading there."""
    length, width = traffic.length[other], min(traffic.width[other], traffic.length[other])
    radius = 0.5 * width
    discs = int(np.ceil(length / width))
    spread = 0.5 * (length - width)
    cos, sin = np.cos(traffic.poses[other, 2]), np.sin(traffic.poses[other, 2])
    nearest, heading = np.inf, 0.0
    for disc in range(discs):
        offset = 0.0 if discs == 1 else spread * (2.0 * disc / (discs - 1) - 1.0)
        x = traffic.poses[other, 0] + offset * cos
        y = traffic.poses[other, 1] + offset * sin
        met, direction = _meets(
            network, traffic, one, x, y, radius + _side(traffic, one, other), horizon
        )
        gap = met - radius - traffic.place[one] - 0.5 * traffic.length[one]
        if gap < nearest:
            nearest, heading = gap, direction
    return nearest, heading


@njit(cache=True)
def _side(traffic: Traffic, one: int, other: int) -> float:
    narrow = (traffic.width[one] < NARROW) + (traffic.width[other] < NARROW)
    if narrow == 0:
        return _SIDE
    return _SIDE_OF_PEOPLE if narrow == 1 else _SIDE_AMONG_PEOPLE


@njit(cache=True)
def _meets(
    network: Network, traffic: Traffic, one: int, x: float, y: float, room: float, horizon: float
) -> tuple[float, float]:
    """Place on the route where the corridor first reaches a point, and the heading there."""
    route = traffic.route[one]
    first, last = network.first[route], network.first[route + 1] - 1
    front = traffic.place[one] + 0.5 * traffic.length[one]
    half = 0.5 * traffic.width[one] + room
    row = first + int(max(front - _BESIDE, 0.0) / SPACING)
    widest = half + traffic.weave[one, 0] + abs(traffic.shift.after[one])
    if (row - first) * SPACING < traffic.shift.begin[one] + traffic.shift.length[one]:
        widest += abs(traffic.shift.before[one])
    while row <= last:
        place = (row - first) * SPACING
        if place > front + horizon + room:
            break
        apart_x, apart_y = x - network.poses[row, 0], y - network.poses[row, 1]
        distance = np.sqrt(apart_x * apart_x + apart_y * apart_y)
        if distance > widest:
            # Nothing nearer than this can come of a shorter step.
            row += max(int((distance - widest) / SPACING), 1)
            continue
        cos, sin = np.cos(network.poses[row, 2]), np.sin(network.poses[row, 2])
        ahead = cos * apart_x + sin * apart_y
        if abs(ahead) <= 0.7 * SPACING or (row == last and ahead > 0.0):
            left = cos * apart_y - sin * apart_x
            if abs(left - _offset(traffic, one, place)) < half:
                return place + ahead, network.poses[row, 2]
        row += 1
    return np.inf, 0.0


@njit(cache=True)
def _offset(traffic: Traffic, one: int, place: float) -> float:
    """`offsets` of one at another place."""
    weave, shift = traffic.weave[one], traffic.shift
    share = min(max((place - shift.begin[one]) / shift.length[one], 0.0), 1.0)
    smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    left = weave[0] * np.sin(2.0 * np.pi / weave[1] * place + weave[2])
    return left + shift.before[one] + (shift.after[one] - shift.before[one]) * smooth
