"""The arrays of a running simulation: all routes in one table, and the places of all travellers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, Integers
from avsec_gym.world.traffic.driving import Manners
from avsec_gym.world.traffic.population import Traveller
from avsec_gym.world.traffic.routes import SPACING, Route, between

NARROW = 1.2
"""A narrower traveller is a person or a cyclist, metres."""
MANNERS = {
    "Car": (1.3, 2.0, 1.4, 2.0),
    "Van": (1.4, 2.0, 1.2, 2.0),
    "Truck": (1.7, 2.5, 0.7, 1.8),
    "Cyclist": (0.9, 1.0, 0.8, 1.6),
    "Pedestrian": (0.4, 0.35, 0.8, 1.2),
}
"""`Manners` by category: headway, distance when standing, acceleration, braking."""


class Network(NamedTuple):
    """R routes, one after the other in a table of P poses."""

    first: Integers
    """Row of each route's first pose, and P, shape (R + 1,)."""
    poses: Floats
    """Shape (P, 3)."""
    limit: Floats
    """Speed for the bends, m/s, shape (P,)."""
    width: Floats
    """The width of the widest on each route, shape (R,)."""
    gate: Floats
    """Shape (R,); see `Route`."""
    clear: Floats
    """Shape (R,)."""
    shown: Floats
    """Shape (R, 2)."""


def network_of(routes: Sequence[Route]) -> Network:
    """The table of some routes."""
    counts = [len(route.poses) for route in routes]
    return Network(
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        np.concatenate([route.poses for route in routes]),
        np.concatenate([route.limits() for route in routes]),
        np.array([route.width for route in routes]),
        np.array([route.gate for route in routes]),
        np.array([route.clear for route in routes]),
        np.array([route.shown for route in routes]),
    )


class Shift(NamedTuple):
    """How N travellers move sideways: from one distance beside the route to another."""

    begin: Floats
    """Place on the route where the movement begins, shape (N,)."""
    length: Floats
    """Metres along the route, shape (N,)."""
    before: Floats
    """The place to the left of the route until then, metres, shape (N,)."""
    after: Floats
    """And thereafter."""


class Traffic(NamedTuple):
    """N travellers; the arrays change over time."""

    route: Integers
    place: Floats
    """Place of the centre, metres on the route."""
    speed: Floats
    poses: Floats
    """Shape (N, 3)."""
    length: Floats
    width: Floats
    desired: Floats
    """Speed on a free road, m/s."""
    weave: Floats
    """Amplitude (m), wavelength (m) and phase (radians) of the small lateral motion, (N, 3)."""
    shift: Shift
    manners: Manners
    opens: Floats
    """Seconds from which a traveller is willing to pass its gate."""
    polite: NDArray[np.bool_]
    """Passes its gate only if no other has to brake for it."""
    committed: NDArray[np.bool_]
    """Has begun to pass its gate."""


def begin(network: Network, travellers: tuple[Traveller, ...]) -> Traffic:
    """Some travellers at time 0."""
    count = len(travellers)
    manners = np.array([MANNERS[traveller.category] for traveller in travellers]).reshape(-1, 4)
    left = np.array([traveller.left for traveller in travellers])
    traffic = Traffic(
        route=np.array([traveller.route for traveller in travellers], np.int64),
        place=np.array([traveller.place for traveller in travellers], float),
        speed=np.array([traveller.speed for traveller in travellers], float),
        poses=np.zeros((count, 3)),
        length=np.array([traveller.dimensions[2] for traveller in travellers]),
        width=np.array([traveller.dimensions[1] for traveller in travellers]),
        desired=np.array([traveller.desired for traveller in travellers]),
        weave=np.array([traveller.weave for traveller in travellers]).reshape(-1, 3),
        shift=Shift(np.full(count, -1e6), np.ones(count), left, left.copy()),
        manners=Manners(*manners.T.copy()),
        opens=np.array([traveller.opens for traveller in travellers]),
        polite=np.array([traveller.polite for traveller in travellers], bool),
        committed=np.array([traveller.started for traveller in travellers], bool),
    )
    traffic.poses[:] = place_all(network, traffic)[0]
    return traffic


def offsets(weave: Floats, shift: Shift, place: Floats) -> tuple[Floats, Floats]:
    """How far to the left of its route each is, metres, and the slope of that; shape (N,) each."""
    wave = 2.0 * np.pi / weave[:, 1]
    angle = wave * place + weave[:, 2]
    share = np.clip((place - shift.begin) / shift.length, 0.0, 1.0)
    way = shift.after - shift.before
    smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    slope = 30.0 * (share * (1.0 - share)) ** 2 / shift.length
    left = weave[:, 0] * np.sin(angle) + shift.before + way * smooth
    return left, weave[:, 0] * wave * np.cos(angle) + way * slope


def on_route(network: Network, route: Integers, place: Floats) -> tuple[Floats, Integers]:
    """Poses at places on routes, shape (N, 3), and the rows before them, shape (N,)."""
    count = network.first[route + 1] - network.first[route]
    station = place / SPACING
    index = np.clip(station.astype(np.int64), 0, count - 2)
    row = network.first[route] + index
    poses = between(network.poses[row], network.poses[row + 1], SPACING, station - index)
    return poses, row


def place_all(network: Network, traffic: Traffic) -> tuple[Floats, Floats]:
    """The poses of all travellers.

    Returns:
        Poses, shape (N, 3), and metres on the route for a metre travelled, shape (N,).
    """
    line, row = on_route(network, traffic.route, traffic.place)
    left, slope = offsets(traffic.weave, traffic.shift, traffic.place)
    bend = (network.poses[row + 1, 2] - network.poses[row, 2]) / SPACING
    forward = 1.0 - bend * left
    sin, cos = np.sin(line[:, 2]), np.cos(line[:, 2])
    poses = np.stack(
        [
            line[:, 0] - left * sin,
            line[:, 1] + left * cos,
            line[:, 2] + np.arctan2(slope, forward),
        ],
        axis=-1,
    )
    return poses, 1.0 / np.hypot(forward, slope)
