"""Lane changes on roads with several lanes each way: MOBIL with German rules.

Kesting, Treiber, Helbing: General lane-changing model MOBIL for car-following models.
Transportation Research Record 1999, 86 (2007): change where one gains, and nobody behind must brake
hard; here also back to the right where that costs nothing.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from avsec_gym.world.traffic.driving import calm_interaction
from avsec_gym.world.traffic.routes import SPACING
from avsec_gym.world.traffic.state import Integers, Network, Traffic

_GAIN = 0.35
"""Acceleration to be won by changing to the left, m/s2."""
_COST = 0.1
"""Acceleration that may be lost by changing to the right."""
_SAFE_BRAKING = 2.0
"""Asked of the new follower at most, m/s2."""
_SLOWEST = 5.0
"""Nobody changes at less, m/s."""
_DURATION = 6.0
"""Seconds that a change takes."""
_REST = 6.0
"""Seconds until the next."""
_NOBODY = -1


@njit(cache=True)
def change_lanes(network: Network, neighbours: Integers, traffic: Traffic) -> None:
    """Let everyone who wants to and can begin to change: gives them a new route and a shift.

    Args:
        network: The routes.
        neighbours: Route of the lane to the left and to the right in the direction of travel,
            -1 for none, shape (R, 2).
        traffic: Changed in place; the poses stay what they are.
    """
    for one in range(len(traffic.place)):
        shift, speed, place = traffic.shift, traffic.speed[one], traffic.place[one]
        rested = shift.begin[one] + shift.length[one] + _REST * speed
        if speed < _SLOWEST or place < rested:
            continue
        route = traffic.route[one]
        own = _acceleration(traffic, one, _ahead(traffic, one, route, place), place)
        for side, least in ((0, own + _GAIN), (1, max(own - _COST, -_COST))):
            target = neighbours[route, side]
            if target >= 0 and _can_change(network, traffic, one, target, least):
                _change(network, traffic, one, target)
                break


@njit(cache=True)
def _can_change(network: Network, traffic: Traffic, one: int, target: int, least: float) -> bool:
    place, _ = _project(network, traffic, one, target)
    ahead = _ahead(traffic, one, target, place)
    if ahead != _NOBODY and _gap(traffic, one, place, ahead) < 2.0 + 0.5 * traffic.speed[one]:
        return False
    if _acceleration(traffic, one, ahead, place) < max(least, -_SAFE_BRAKING):
        return False
    behind = _behind(traffic, one, target, place)
    if behind == _NOBODY:
        return True
    # Seen from the new follower, one will be ahead of it.
    gap = place - traffic.place[behind] - 0.5 * (traffic.length[one] + traffic.length[behind])
    braked = _following(traffic, behind, gap, traffic.speed[one])
    return gap > 2.0 + 0.5 * traffic.speed[behind] and braked > -_SAFE_BRAKING


@njit(cache=True)
def _change(network: Network, traffic: Traffic, one: int, target: int) -> None:
    """Onto the other route, at the same pose, with a shift to its middle."""
    place, left = _project(network, traffic, one, target)
    weave, shift = traffic.weave[one], traffic.shift
    weave[2] += 2.0 * np.pi / weave[1] * (traffic.place[one] - place)
    traffic.route[one], traffic.place[one] = target, place
    shift.begin[one], shift.length[one] = place, max(_DURATION * traffic.speed[one], 40.0)
    shift.before[one] = left - weave[0] * np.sin(2.0 * np.pi / weave[1] * place + weave[2])
    shift.after[one] = 0.0


@njit(cache=True)
def _project(network: Network, traffic: Traffic, one: int, target: int) -> tuple[float, float]:
    """Place on another route beside one, and how far to its left one is."""
    x, y = traffic.poses[one, 0], traffic.poses[one, 1]
    first, last = network.first[target], network.first[target + 1] - 2
    row = min(first + int(traffic.place[one] / SPACING), last)
    # Towards the foot of the perpendicular; the lanes are nearly parallel.
    for _ in range(8):
        step = int(np.floor(_ahead_of_row(network, row, x, y) / SPACING))
        row = min(max(row + step, first), last)
        if step == 0:
            break
    share = _ahead_of_row(network, row, x, y) / SPACING
    one_x = network.poses[row, 0] + share * (network.poses[row + 1, 0] - network.poses[row, 0])
    one_y = network.poses[row, 1] + share * (network.poses[row + 1, 1] - network.poses[row, 1])
    heading = network.poses[row, 2]
    heading += share * (network.poses[row + 1, 2] - heading)
    left = np.cos(heading) * (y - one_y) - np.sin(heading) * (x - one_x)
    return (row - first + share) * SPACING, left


@njit(cache=True)
def _ahead_of_row(network: Network, row: int, x: float, y: float) -> float:
    """Metres from a pose of the table to a place, along the pose's heading."""
    heading = network.poses[row, 2]
    along = (x - network.poses[row, 0]) * np.cos(heading)
    return along + (y - network.poses[row, 1]) * np.sin(heading)


@njit(cache=True)
def _ahead(traffic: Traffic, one: int, route: int, place: float) -> int:
    """Who drives next ahead of a place on a route, but one itself."""
    found, nearest = _NOBODY, np.inf
    for other in range(len(traffic.place)):
        there = other != one and traffic.route[other] == route
        if there and place <= traffic.place[other] < nearest:
            found, nearest = other, traffic.place[other]
    return found


@njit(cache=True)
def _behind(traffic: Traffic, one: int, route: int, place: float) -> int:
    """Who drives next behind a place on a route, but one itself."""
    found, nearest = _NOBODY, -np.inf
    for other in range(len(traffic.place)):
        there = other != one and traffic.route[other] == route
        if there and nearest < traffic.place[other] < place:
            found, nearest = other, traffic.place[other]
    return found


@njit(cache=True)
def _gap(traffic: Traffic, one: int, place: float, ahead: int) -> float:
    return traffic.place[ahead] - place - 0.5 * (traffic.length[one] + traffic.length[ahead])


@njit(cache=True)
def _acceleration(traffic: Traffic, one: int, ahead: int, place: float) -> float:
    """Of one at a place behind another, or alone."""
    if ahead == _NOBODY:
        return _following(traffic, one, np.inf, traffic.speed[one])
    return _following(traffic, one, _gap(traffic, one, place, ahead), traffic.speed[ahead])


@njit(cache=True)
def _following(traffic: Traffic, one: int, gap: float, speed_ahead: float) -> float:
    """Acceleration of the IDM."""
    manners, speed = traffic.manners, traffic.speed[one]
    felt = calm_interaction(
        speed,
        gap,
        speed - speed_ahead,
        manners.headway[one],
        manners.standstill[one],
        manners.acceleration[one],
        manners.braking[one],
    )
    return manners.acceleration[one] * (1.0 - (speed / traffic.desired[one]) ** 4 - felt)
