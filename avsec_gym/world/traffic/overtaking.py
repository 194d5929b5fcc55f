"""Lane changes on roads with several lanes each way: MOBIL with German rules.

Kesting, Treiber, Helbing: General lane-changing model MOBIL for car-following models.
Transportation Research Record 1999, 86 (2007): a driver changes lanes to gain, if no vehicle behind
must brake hard; here also back to the right where that costs nothing.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Integers
from avsec_gym.kernels import kernel
from avsec_gym.world.traffic.driving import calm_interaction
from avsec_gym.world.traffic.routes import SPACING
from avsec_gym.world.traffic.state import Network, Traffic

_GAIN = 0.35
"""Acceleration to be won by changing to the left, m/s2."""
_COST = 0.1
"""Acceleration that may be lost by changing to the right."""
_SAFE_BRAKING = 2.0
"""Asked of the new follower at most, m/s2."""
_SLOWEST = 5.0
"""Least speed for a change, m/s."""
_DURATION = 6.0
"""Seconds that a change takes."""
_REST = 6.0
"""Seconds until the next."""
_NONE = -1


@kernel()
def change_lanes(network: Network, neighbours: Integers, traffic: Traffic) -> None:
    """Let every traveller that wants to and can begin to change: sets its new route and shift.

    Invariant: a change keeps the pose. The route jumps, and the shift begins with the distance
    that the traveller then has from it.

    Args:
        network: The routes.
        neighbours: Route of the lane to the left and to the right in the direction of travel,
            -1 for none, shape (R, 2).
        traffic: The travellers, changed in place; the poses stay what they are.
    """
    for traveller in range(len(traffic.place)):
        shift, speed, place = traffic.shift, traffic.speed[traveller], traffic.place[traveller]
        rested = shift.begin[traveller] + shift.length[traveller] + _REST * speed
        if speed < _SLOWEST or place < rested:
            continue
        route = traffic.route[traveller]
        own = _acceleration(traffic, traveller, _ahead(traffic, traveller, route, place), place)
        # Left for a gain in acceleration; right where the loss is small.
        for side, least in ((0, own + _GAIN), (1, max(own - _COST, -_COST))):
            target = neighbours[route, side]
            if target >= 0 and _can_change(network, traffic, traveller, target, least):
                _change(network, traffic, traveller, target)
                break


@kernel()
def _can_change(
    network: Network, traffic: Traffic, traveller: int, target: int, least: float
) -> bool:
    """Whether a change pays and disturbs no traveller on the other route."""
    place, _ = _project(network, traffic, traveller, target)
    ahead = _ahead(traffic, traveller, target, place)
    if (
        ahead != _NONE
        and _gap(traffic, traveller, place, ahead) < 2.0 + 0.5 * traffic.speed[traveller]
    ):
        return False
    if _acceleration(traffic, traveller, ahead, place) < max(least, -_SAFE_BRAKING):
        return False
    behind = _behind(traffic, traveller, target, place)
    if behind == _NONE:
        return True
    # Seen from the new follower, the traveller will be ahead of it.
    gap = place - traffic.place[behind] - 0.5 * (traffic.length[traveller] + traffic.length[behind])
    braked = _following(traffic, behind, gap, traffic.speed[traveller])
    return gap > 2.0 + 0.5 * traffic.speed[behind] and braked > -_SAFE_BRAKING


@kernel()
def _change(network: Network, traffic: Traffic, traveller: int, target: int) -> None:
    """Onto the other route, at the same pose, with a shift to its middle."""
    place, left = _project(network, traffic, traveller, target)
    weave, shift = traffic.weave[traveller], traffic.shift
    weave[2] += 2.0 * np.pi / weave[1] * (traffic.place[traveller] - place)
    traffic.route[traveller], traffic.place[traveller] = target, place
    shift.begin[traveller], shift.length[traveller] = (
        place,
        max(_DURATION * traffic.speed[traveller], 40.0),
    )
    shift.before[traveller] = left - weave[0] * np.sin(2.0 * np.pi / weave[1] * place + weave[2])
    shift.after[traveller] = 0.0


@kernel()
def _project(
    network: Network, traffic: Traffic, traveller: int, target: int
) -> tuple[float, float]:
    """Place on another route beside a traveller, and the traveller's distance to its left."""
    x, y = traffic.poses[traveller, 0], traffic.poses[traveller, 1]
    first, last = network.first[target], network.first[target + 1] - 2
    row = min(first + int(traffic.place[traveller] / SPACING), last)
    # Towards the foot of the perpendicular; the lanes are nearly parallel.
    for _ in range(8):
        step = int(np.floor(_ahead_of_row(network, row, x, y) / SPACING))
        row = min(max(row + step, first), last)
        if step == 0:
            break
    share = _ahead_of_row(network, row, x, y) / SPACING
    foot_x = network.poses[row, 0] + share * (network.poses[row + 1, 0] - network.poses[row, 0])
    foot_y = network.poses[row, 1] + share * (network.poses[row + 1, 1] - network.poses[row, 1])
    heading = network.poses[row, 2]
    heading += share * (network.poses[row + 1, 2] - heading)
    left = np.cos(heading) * (y - foot_y) - np.sin(heading) * (x - foot_x)
    return (row - first + share) * SPACING, left


@kernel()
def _ahead_of_row(network: Network, row: int, x: float, y: float) -> float:
    """Metres from a pose of the table to a place, along the pose's heading."""
    heading = network.poses[row, 2]
    along = (x - network.poses[row, 0]) * np.cos(heading)
    return along + (y - network.poses[row, 1]) * np.sin(heading)


@kernel()
def _ahead(traffic: Traffic, traveller: int, route: int, place: float) -> int:
    """The next traveller ahead of a place on a route, other than the given one."""
    found, nearest = _NONE, np.inf
    for other in range(len(traffic.place)):
        there = other != traveller and traffic.route[other] == route
        if there and place <= traffic.place[other] < nearest:
            found, nearest = other, traffic.place[other]
    return found


@kernel()
def _behind(traffic: Traffic, traveller: int, route: int, place: float) -> int:
    """The next traveller behind a place on a route, other than the given one."""
    found, nearest = _NONE, -np.inf
    for other in range(len(traffic.place)):
        there = other != traveller and traffic.route[other] == route
        if there and nearest < traffic.place[other] < place:
            found, nearest = other, traffic.place[other]
    return found


@kernel()
def _gap(traffic: Traffic, traveller: int, place: float, ahead: int) -> float:
    """Free metres from a traveller at a place to the one ahead on the same route."""
    return traffic.place[ahead] - place - 0.5 * (traffic.length[traveller] + traffic.length[ahead])


@kernel()
def _acceleration(traffic: Traffic, traveller: int, ahead: int, place: float) -> float:
    """Acceleration of a traveller at a place behind another, or alone."""
    if ahead == _NONE:
        return _following(traffic, traveller, np.inf, traffic.speed[traveller])
    return _following(
        traffic, traveller, _gap(traffic, traveller, place, ahead), traffic.speed[ahead]
    )


@kernel()
def _following(traffic: Traffic, traveller: int, gap: float, speed_ahead: float) -> float:
    """Acceleration of the IDM."""
    manners, speed = traffic.manners, traffic.speed[traveller]
    felt = calm_interaction(
        speed,
        gap,
        speed - speed_ahead,
        manners.headway[traveller],
        manners.standstill[traveller],
        manners.acceleration[traveller],
        manners.braking[traveller],
    )
    return manners.acceleration[traveller] * (
        1.0 - (speed / traffic.desired[traveller]) ** 4 - felt
    )
