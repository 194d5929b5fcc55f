"""The strongest interaction of each traveller with anything in the corridor ahead of it."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
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
"""An obstacle less than this behind a traveller's front is still ahead, metres."""


@kernel()
def interactions_ahead(network: Network, traffic: Traffic) -> Floats:
    """Strongest `calm_interaction` of each with another that is in the way, shape (N,).

    A footprint is a row of discs as wide as it; the corridor is the stretch of the route ahead,
    with the sideways motion still to come.

    Invariant: reads the traffic, never writes it, so that the order of travellers has no effect.
    """
    count = len(traffic.place)
    strongest = np.zeros(count)
    for traveller in range(count):
        speed = traffic.speed[traveller]
        horizon = min(4.0 + 2.0 * speed + speed * speed / 2.6, _FARTHEST)
        for other in range(count):
            if other == traveller:
                continue
            apart_x = traffic.poses[other, 0] - traffic.poses[traveller, 0]
            apart_y = traffic.poses[other, 1] - traffic.poses[traveller, 1]
            reach = horizon + 0.5 * traffic.length[traveller] + traffic.length[other]
            # Drop pairs by their distance first: nearly all end here.
            squared = apart_x * apart_x + apart_y * apart_y
            if squared > reach * reach:
                continue
            forward = apart_x * np.cos(traffic.poses[traveller, 2])
            forward += apart_y * np.sin(traffic.poses[traveller, 2])
            # No turn leads back to what is far behind.
            if forward < -_BEHIND - 0.5 * traffic.length[other]:
                continue
            gap, heading = _gap(network, traffic, traveller, other, horizon)
            # Only the other's speed along the corridor counts; an oncoming one counts as standing.
            if gap < horizon:
                theirs = traffic.speed[other] * np.cos(traffic.poses[other, 2] - heading)
                felt = calm_interaction(
                    speed,
                    gap,
                    speed - max(theirs, 0.0),
                    traffic.manners.headway[traveller],
                    traffic.manners.standstill[traveller],
                    traffic.manners.acceleration[traveller],
                    traffic.manners.braking[traveller],
                )
                strongest[traveller] = max(strongest[traveller], felt)
    return strongest


@kernel()
def _gap(
    network: Network, traffic: Traffic, traveller: int, other: int, horizon: float
) -> tuple[float, float]:
    """Free metres on the route to another's footprint, and the route's heading there."""
    length, width = traffic.length[other], min(traffic.width[other], traffic.length[other])
    radius = 0.5 * width
    discs = int(np.ceil(length / width))
    spread = 0.5 * (length - width)
    cos, sin = np.cos(traffic.poses[other, 2]), np.sin(traffic.poses[other, 2])
    # Discs from rear to front, evenly spread over the footprint's length.
    nearest, heading = np.inf, 0.0
    for disc in range(discs):
        offset = 0.0 if discs == 1 else spread * (2.0 * disc / (discs - 1) - 1.0)
        x = traffic.poses[other, 0] + offset * cos
        y = traffic.poses[other, 1] + offset * sin
        met, direction = _meets(
            network, traffic, traveller, x, y, radius + _side(traffic, traveller, other), horizon
        )
        gap = met - radius - traffic.place[traveller] - 0.5 * traffic.length[traveller]
        if gap < nearest:
            nearest, heading = gap, direction
    return nearest, heading


@kernel()
def _side(traffic: Traffic, traveller: int, other: int) -> float:
    """Room that a traveller leaves beside another, metres."""
    narrow = (traffic.width[traveller] < NARROW) + (traffic.width[other] < NARROW)
    if narrow == 0:
        return _SIDE
    return _SIDE_OF_PEOPLE if narrow == 1 else _SIDE_AMONG_PEOPLE


@kernel()
def _meets(
    network: Network,
    traffic: Traffic,
    traveller: int,
    x: float,
    y: float,
    room: float,
    horizon: float,
) -> tuple[float, float]:
    """Place on the route where the corridor first reaches a point, and the heading there."""
    route = traffic.route[traveller]
    first, last = network.first[route], network.first[route + 1] - 1
    front = traffic.place[traveller] + 0.5 * traffic.length[traveller]
    half = 0.5 * traffic.width[traveller] + room
    row = first + int(max(front - _BESIDE, 0.0) / SPACING)
    # Bound of the corridor's reach from the route: weaving, and a lane change under way.
    widest = half + traffic.weave[traveller, 0] + abs(traffic.shift.after[traveller])
    if (row - first) * SPACING < traffic.shift.begin[traveller] + traffic.shift.length[traveller]:
        widest += abs(traffic.shift.before[traveller])
    while row <= last:
        place = (row - first) * SPACING
        if place > front + horizon + room:
            break
        apart_x, apart_y = x - network.poses[row, 0], y - network.poses[row, 1]
        distance = np.sqrt(apart_x * apart_x + apart_y * apart_y)
        if distance > widest:
            # Distances along a line change by a step at most: none of the skipped rows is nearer.
            row += max(int((distance - widest) / SPACING), 1)
            continue
        cos, sin = np.cos(network.poses[row, 2]), np.sin(network.poses[row, 2])
        ahead = cos * apart_x + sin * apart_y
        if abs(ahead) <= 0.7 * SPACING or (row == last and ahead > 0.0):
            left = cos * apart_y - sin * apart_x
            if abs(left - _offset(traffic, traveller, place)) < half:
                return place + ahead, network.poses[row, 2]
        row += 1
    return np.inf, 0.0


@kernel()
def _offset(traffic: Traffic, traveller: int, place: float) -> float:
    """`offsets` of a traveller at another place."""
    weave, shift = traffic.weave[traveller], traffic.shift
    share = min(max((place - shift.begin[traveller]) / shift.length[traveller], 0.0), 1.0)
    smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    left = weave[0] * np.sin(2.0 * np.pi / weave[1] * place + weave[2])
    return (
        left + shift.before[traveller] + (shift.after[traveller] - shift.before[traveller]) * smooth
    )
