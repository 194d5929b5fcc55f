"""Lane changes on roads with several lanes each way: MOBIL with German rules.

Kesting, Treiber, Helbing: General lane-changing model MOBIL for car-following models.
Transportation Research Record 1999, 86 (2007): change where one gains, and nobody behind must brake
hard; here also back to the right where that costs nothing.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.traffic.driving import Manners, idm_acceleration, idm_interaction
from avsec_gym.world.traffic.routes import SPACING
from avsec_gym.world.traffic.state import Integers, Network, Traffic, offsets, on_route

_GAIN = 0.35
"""Acceleration to be won by changing to the left, m/s2."""
_COST = 0.1
"""Acceleration that may be lost by changing to the right."""
_SAFE_BRAKING = 2.0
"""Asked of the new follower at most, m/s2."""
_DURATION = 5.0
"""Seconds that a change takes."""
_REST = 6.0
"""Seconds until the next."""


def change_lanes(network: Network, neighbours: Integers, traffic: Traffic) -> None:
    """Let everyone who wants to and can begin to change: gives them a new route and a shift.

    Args:
        network: The routes.
        neighbours: Route of the lane to the left and to the right in the direction of travel,
            -1 for none, shape (R, 2).
        traffic: Changed in place; the poses stay what they are.
    """
    for one in np.flatnonzero((neighbours[traffic.route] >= 0).any(axis=1)):
        speed = traffic.speed[one]
        rested = traffic.shift.begin[one] + traffic.shift.length[one] + _REST * speed
        if speed < 5.0 or traffic.place[one] < rested:
            continue
        own = _acceleration(traffic, one, _leader(traffic, one, traffic.route[one]))
        for side, least in ((0, own + _GAIN), (1, own - _COST)):
            target = int(neighbours[traffic.route[one], side])
            if target >= 0 and _can_change(network, traffic, one, target, least):
                _change(network, traffic, one, target)
                break


def _can_change(
    network: Network, traffic: Traffic, one: int, target: int, least: float
) -> bool:
    place, _ = _project(network, traffic, one, target)
    ahead = _leader(traffic, one, target, place)
    behind = _follower(traffic, target, place)
    if ahead is not None and ahead[1] < 2.0 + 0.5 * traffic.speed[one]:
        return False
    if _acceleration(traffic, one, ahead) < max(least, -_SAFE_BRAKING):
        return False
    if behind is None:
        return True
    follower, gap = behind[0], behind[1] - 0.5 * traffic.length[one]
    braked = _acceleration(traffic, follower, (one, gap))
    return gap > 2.0 + 0.5 * traffic.speed[follower] and braked > -_SAFE_BRAKING


def _change(network: Network, traffic: Traffic, one: int, target: int) -> None:
    """Onto the other route, at the same pose, with a shift to its middle."""
    place, left = _project(network, traffic, one, target)
    weave, shift = traffic.weave[one], traffic.shift
    weave[2] += 2.0 * np.pi / weave[1] * (traffic.place[one] - place)
    traffic.route[one], traffic.place[one] = target, place
    shift.begin[one], shift.length[one] = place, max(_DURATION * traffic.speed[one], 40.0)
    shift.before[one] = left - weave[0] * np.sin(2.0 * np.pi / weave[1] * place + weave[2])
    shift.after[one] = 0.0


def _project(network: Network, traffic: Traffic, one: int, target: int) -> tuple[float, float]:
    """Place on another route beside one, and how far to its left one is."""
    rows = slice(network.first[target], network.first[target + 1])
    x, y = traffic.poses[one, :2]
    distance = ((network.poses[rows, :2] - (x, y)) ** 2).sum(axis=1)
    place, left = SPACING * float(distance.argmin()), 0.0
    for _ in range(3):
        line, _ = on_route(network, np.array([target]), np.array([place]))
        cos, sin = np.cos(line[0, 2]), np.sin(line[0, 2])
        apart = (x - line[0, 0], y - line[0, 1])
        place += cos * apart[0] + sin * apart[1]
        left = cos * apart[1] - sin * apart[0]
    return place, float(left)


def _leader(
    traffic: Traffic, one: int, route: int, place: float | None = None
) -> tuple[int, float] | None:
    """Who drives ahead of one on a route, and the gap to it."""
    place = traffic.place[one] if place is None else place
    there = (traffic.route == route) & (traffic.place >= place)
    there[one] = False
    if not there.any():
        return None
    ahead = int(np.where(there, traffic.place, np.inf).argmin())
    lengths = 0.5 * (traffic.length[one] + traffic.length[ahead])
    return ahead, float(traffic.place[ahead] - place - lengths)


def _follower(traffic: Traffic, route: int, place: float) -> tuple[int, float] | None:
    """Who drives behind a place on a route, and how far its front is from there."""
    there = (traffic.route == route) & (traffic.place < place)
    if not there.any():
        return None
    behind = int(np.where(there, traffic.place, -np.inf).argmax())
    return behind, float(place - traffic.place[behind] - 0.5 * traffic.length[behind])


def _acceleration(traffic: Traffic, one: int, ahead: tuple[int, float] | None) -> float:
    manners = Manners(*(float(column[one]) for column in traffic.manners))
    felt = 0.0
    if ahead is not None:
        closing = traffic.speed[one] - traffic.speed[ahead[0]]
        felt = idm_interaction(traffic.speed[one], ahead[1], closing, *manners)
    return float(idm_acceleration(traffic.speed[one], traffic.desired[one], felt, manners))
