"""Right of way: turning, joining and crossing travellers wait at gates for the others to pass.

A route with a gate crosses or joins others between `gate` and `clear`. Where it comes near another
route, both have a *zone*. A traveller that has begun to pass its gate holds its zones until its
rear has left them, and no other enters a zone that is held. So two travellers pass a zone only one
after the other, by construction.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avsec_gym.geometry import Floats, Integers
from avsec_gym.kernels import kernel
from avsec_gym.world.traffic.driving import calm_interaction
from avsec_gym.world.traffic.routes import SPACING
from avsec_gym.world.traffic.state import NARROW, Network, Traffic

_ROOM = 0.4
"""Between footprints on routes that do not conflict, metres."""
_BEFORE_GATE = 3.0
"""Routes that pass here together, metres before the gate, are followed, not crossed."""
_PATIENCE = 1.5
"""Seconds that others are away after a polite traveller has passed."""
_STOPPING = 2.0
"""Braking that may be asked of others, m/s2."""
_WALKING = 2.5
"""A slower traveller walks, m/s."""
_STOP_BEFORE = 0.5
"""Where fronts come to rest before a gate or a zone, metres."""


class Zones(NamedTuple):
    """Z stretches that two routes share, one of them behind its gate."""

    minor: Integers
    """The route with the gate, shape (Z,)."""
    major: Integers
    """The other route."""
    minor_begin: Floats
    """Where the zone begins on the minor route, metres."""
    minor_end: Floats
    major_begin: Floats
    major_end: Floats


def find_zones(network: Network) -> Zones:
    """Every zone of a network."""
    found = _find_zones(network)
    minor, major = found[:, 0].astype(np.int64), found[:, 1].astype(np.int64)
    return Zones(minor, major, *found[:, 2:].T.copy())


@kernel()
def _find_zones(network: Network) -> Floats:
    """A row of `Zones` for each pair of routes that come near each other behind a gate, (Z, 6)."""
    routes = len(network.gate)
    rows = []
    for minor in range(routes):
        if not np.isfinite(network.gate[minor]):
            continue
        # The stretch of the minor route between its gate and `clear`.
        start = network.first[minor]
        last = network.first[minor + 1] - 1
        begin = start + int(network.gate[minor] / SPACING)
        end = min(start + int(network.clear[minor] / SPACING) + 1, last)
        before = start + int(max(network.gate[minor] - _BEFORE_GATE, 0.0) / SPACING)
        for major in range(routes):
            if major == minor:
                continue
            near = 0.5 * (network.width[minor] + network.width[major]) + _ROOM
            # Extent of the zone so far, as rows of both routes; empty while low > high.
            low, high, major_low, major_high = np.inf, -np.inf, np.inf, -np.inf
            together = False
            row = network.first[major]
            while row < network.first[major + 1]:
                x, y = network.poses[row, 0], network.poses[row, 1]
                middle = (begin + end) // 2
                # Far from the whole stretch: skip ahead.
                away = np.hypot(x - network.poses[middle, 0], y - network.poses[middle, 1])
                spare = away - near - (end - begin) * SPACING - 2 * _BEFORE_GATE
                if spare > SPACING:
                    row += int(spare / SPACING)
                    continue
                # Routes that share the approach are followed: they have no zone.
                turn = network.poses[row, 2] - network.poses[before, 2]
                if (
                    np.hypot(x - network.poses[before, 0], y - network.poses[before, 1]) < 0.4
                    and np.cos(turn) > 0.95
                ):
                    together = True
                    break
                for own in range(begin, end + 1):
                    if np.hypot(x - network.poses[own, 0], y - network.poses[own, 1]) < near:
                        low, high = min(low, own), max(high, own)
                        major_low, major_high = min(major_low, row), max(major_high, row)
                row += 1
            if not together and low <= high:
                rows.append(
                    (
                        float(minor),
                        float(major),
                        (low - start) * SPACING,
                        (high - start) * SPACING,
                        (major_low - network.first[major]) * SPACING,
                        (major_high - network.first[major]) * SPACING,
                    )
                )
    found = np.zeros((len(rows), 6))
    for index in range(len(rows)):
        for column in range(6):
            found[index, column] = rows[index][column]
    return found


@kernel()
def pass_gates(network: Network, zones: Zones, traffic: Traffic, time: float) -> None:
    """Let travellers begin that have come to their gate and find it free: sets `committed`.

    Invariant: a traveller that begins holds its zones at once, so that those after it in the loop
    find them held.
    """
    for traveller in range(len(traffic.place)):
        gate = network.gate[traffic.route[traveller]]
        if traffic.committed[traveller] or not np.isfinite(gate) or time < traffic.opens[traveller]:
            continue
        speed = traffic.speed[traveller]
        distance = gate - traffic.place[traveller] - 0.5 * traffic.length[traveller]
        if distance < speed * speed / 2.4 + 4.0 and _is_free(network, zones, traffic, traveller):
            traffic.committed[traveller] = True


@kernel()
def _is_free(network: Network, zones: Zones, traffic: Traffic, traveller: int) -> bool:
    """Whether no other is in a traveller's zones or holds one, and those who come can stop."""
    route = traffic.route[traveller]
    rear = traffic.place[traveller] - 0.5 * traffic.length[traveller]
    for zone in range(len(zones.minor)):
        for other in range(len(traffic.place)):
            if other == traveller:
                continue
            # Another holds a zone on this route and has not left it.
            if (
                zones.major[zone] == route
                and zones.minor[zone] == traffic.route[other]
                and _holds(network, traffic, other)
                and traffic.place[other] - 0.5 * traffic.length[other] < zones.minor_end[zone]
                and rear < zones.major_end[zone]
            ):
                return False
            # Another on the route with priority comes too close.
            if (
                zones.minor[zone] == route
                and zones.major[zone] == traffic.route[other]
                and not _lets_pass(network, zones, traffic, traveller, other, zone)
            ):
                return False
    return True


@kernel()
def _holds(network: Network, traffic: Traffic, traveller: int) -> bool:
    """Whether a traveller has begun to pass its gate and has not left its zones."""
    rear = traffic.place[traveller] - 0.5 * traffic.length[traveller]
    return traffic.committed[traveller] and rear < network.clear[traffic.route[traveller]]


@kernel()
def _lets_pass(
    network: Network, zones: Zones, traffic: Traffic, traveller: int, other: int, zone: int
) -> bool:
    """Whether another on the zone's major route leaves a traveller the time to pass."""
    # Past the zone already, or in it.
    half = 0.5 * traffic.length[other]
    if traffic.place[other] - half > zones.major_end[zone]:
        return True
    gap = zones.major_begin[zone] - traffic.place[other] - half
    if gap < 0.0:
        return False
    # Waiting at a gate of its own before the zone, standing, or too close to stop.
    gate = network.gate[traffic.route[other]]
    if not traffic.committed[other] and gate <= zones.major_begin[zone] + 0.1:
        return True
    speed = traffic.speed[other]
    if speed < 0.1:
        return True
    if gap < speed * speed / (2.0 * _STOPPING) + 0.5 * speed + 1.0:
        return False
    # People make each other wait a little.
    among_people = traffic.width[traveller] < NARROW and speed < _WALKING
    if among_people or not traffic.polite[traveller]:
        return True
    distance = zones.minor_end[zone] - traffic.place[traveller] + 0.5 * traffic.length[traveller]
    takes = _travel_time(traffic, traveller, distance, min(traffic.desired[traveller], 5.5))
    return _travel_time(traffic, other, gap, traffic.desired[other]) > takes + _PATIENCE


@kernel()
def _travel_time(traffic: Traffic, traveller: int, distance: float, top: float) -> float:
    """Seconds for a distance when speeding up to the top speed."""
    speed, acceleration = (
        min(traffic.speed[traveller], top),
        traffic.manners.acceleration[traveller],
    )
    gathering = (top * top - speed * speed) / (2.0 * acceleration)
    if distance < gathering:
        return (np.sqrt(speed * speed + 2.0 * acceleration * distance) - speed) / acceleration
    return (top - speed) / acceleration + (distance - gathering) / top


@kernel()
def interactions_with_gates(network: Network, zones: Zones, traffic: Traffic) -> Floats:
    """Strongest `calm_interaction` of each with its closed gate and with held zones, shape (N,)."""
    strongest = np.zeros(len(traffic.place))
    for traveller in range(len(traffic.place)):
        front = traffic.place[traveller] + 0.5 * traffic.length[traveller]
        gate = network.gate[traffic.route[traveller]]
        if not traffic.committed[traveller] and np.isfinite(gate):
            strongest[traveller] = _with_line(traffic, traveller, gate - front)
        if not _holds(network, traffic, traveller):
            continue
        rear = traffic.place[traveller] - 0.5 * traffic.length[traveller]
        for zone in range(len(zones.minor)):
            if zones.minor[zone] != traffic.route[traveller] or rear > zones.minor_end[zone]:
                continue
            takes = (zones.minor_end[zone] - rear) / max(traffic.speed[traveller], 1.0) + 1.0
            for other in range(len(traffic.place)):
                if other == traveller or traffic.route[other] != zones.major[zone]:
                    continue
                reach = traffic.place[other] + 0.5 * traffic.length[other]
                gap = zones.major_begin[zone] - reach
                # A traveller that arrives after the zone is left need not slow down.
                if gap >= 0.0 and gap < traffic.speed[other] * takes + 5.0:
                    strongest[other] = max(strongest[other], _with_line(traffic, other, gap))
    return strongest


@kernel()
def _with_line(traffic: Traffic, traveller: int, gap: float) -> float:
    """Interaction with a line at which to stop."""
    speed, standstill = traffic.speed[traveller], traffic.manners.standstill[traveller]
    return calm_interaction(
        speed,
        max(gap, 0.0) + max(standstill - _STOP_BEFORE, 0.0),
        speed,
        traffic.manners.headway[traveller],
        standstill,
        traffic.manners.acceleration[traveller],
        traffic.manners.braking[traveller],
    )
