"""Vehicles and cyclists in the lanes, before red lights, and in side streets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.world.layouts.dimensions import CATEGORIES, CategoryMix, draw_dimensions
from avsec_gym.world.site import Site, Style
from avsec_gym.world.traffic.driving import calm_interaction
from avsec_gym.world.traffic.population import Traveller
from avsec_gym.world.traffic.roads import Roads
from avsec_gym.world.traffic.routes import SPACING
from avsec_gym.world.traffic.state import MANNERS
from avsec_gym.world.traffic.styles import Bustle

_CYCLIST = int(np.flatnonzero(CATEGORIES == "Cyclist")[0])
_SMALL = CategoryMix(Car=0.93, Van=0.07)
_BRAKING = 1.5
"""The braking at time 0, m/s2 at most."""
_WIDEST_RIDER = 0.7
"""Metres; a cyclist that is passed in a lane must not be wider."""
_CLOSEST = 1.5
"""Metres between those who follow each other at time 0."""


def draw_vehicle(
    bustle: Bustle, widest: float, rng: np.random.Generator
) -> tuple[str, tuple[float, float, float]]:
    """Category and size of a vehicle that fits into a lane."""
    codes = bustle.mix.draw(rng, 1)
    height, width, length = draw_dimensions(rng, codes)[0].tolist()
    return str(CATEGORIES[codes[0]]), (height, min(width, widest), length)


def draw_weave(category: str, rng: np.random.Generator) -> tuple[float, float, float]:
    """The small lateral motion of a driver, a cyclist, or a walker."""
    high, wave = {"Cyclist": (0.06, 11.0), "Pedestrian": (0.02, 5.0)}.get(category, (0.07, 75.0))
    return (
        high * float(rng.uniform(0.4, 1.2)),
        wave * float(rng.uniform(0.8, 1.4)),
        float(rng.uniform(0.0, 2 * np.pi)),
    )


def fill_lane(
    site: Site, roads: Roads, lane: int, bustle: Bustle, jam: float, rng: np.random.Generator
) -> list[Traveller]:
    """Vehicles along a lane, some of which will turn off.

    Args:
        site: The place.
        roads: The routes.
        lane: Index of the lane.
        bustle: Amount of traffic.
        jam: Share of their speed that a jam leaves the drivers, 1 without one.
        rng: The source of chance.

    Returns:
        One behind the other, at the speeds that they want; see `settle`.
    """
    usual = site.section.lanes[lane].speed
    widest = max(site.section.lanes[lane].width - 0.35, 1.5)
    route = roads.routes[roads.lanes[lane]]
    turns = [turn for start, turn in roads.exits if start == roads.lanes[lane]]
    vehicles, place = [], float(rng.exponential(bustle.flow))
    while np.isfinite(bustle.flow) and place < route.length:
        category, size = draw_vehicle(bustle, widest, rng)
        desired = usual * jam * float(rng.uniform(*bustle.pace))
        if category == "Truck" and site.style == Style.HIGHWAY:
            desired = min(desired, float(rng.uniform(22.5, 24.5)))
        place += 0.5 * size[2]
        turn = int(rng.choice(turns)) if turns and rng.random() < bustle.turning else -1
        if turn >= 0 and size[2] < 5.5 and place + 25.0 < roads.routes[turn].gate:
            index = turn
        else:
            index = roads.lanes[lane]
        vehicles.append(
            Traveller(category, size, index, place, desired, desired, draw_weave(category, rng))
        )
        room = bustle.flow * (0.1 if jam < 1.0 else 1.0)
        place += 0.5 * size[2] + 2.5 + 1.3 * desired + float(rng.exponential(room))
    return vehicles


def fill_side_street(
    roads: Roads, street: int, bustle: Bustle, rng: np.random.Generator
) -> list[Traveller]:
    """Vehicles that come out of a side street, the first of them often waiting at its end."""
    vehicles: list[Traveller] = []
    entries = roads.entries[street]
    if not entries:
        return vehicles
    behind = 0.3 if rng.random() < 0.6 else float(rng.uniform(5.0, 25.0))
    for _ in range(min(int(rng.poisson(bustle.waiting)), 3)):
        category, size = draw_vehicle(replace(bustle, mix=_SMALL), 1.85, rng)
        index = int(rng.choice(entries))
        place = roads.routes[index].gate - behind - 0.5 * size[2]
        if place < 0.5 * size[2]:
            break
        weave = draw_weave(category, rng)
        polite = bool(rng.random() < 0.5)
        vehicles.append(Traveller(category, size, index, place, 8.0, 10.0, weave, polite=polite))
        behind += size[2] + float(rng.uniform(2.0, 6.0))
    return vehicles


def fill_cycling(
    site: Site, roads: Roads, route: int, bustle: Bustle, rng: np.random.Generator
) -> list[Traveller]:
    """Cyclists on a cycle path or in the right part of a lane."""
    length = roads.routes[route].length
    count = int(rng.poisson(bustle.riders * length / 100.0))
    sizes = draw_dimensions(rng, np.full(count, _CYCLIST))
    sizes[:, 1] = np.minimum(sizes[:, 1], _WIDEST_RIDER)
    riders, last = [], -10.0
    for place, size in zip(np.sort(rng.uniform(0.0, length, count)), sizes.tolist(), strict=True):
        if place - last > 5.0:
            speed = float(np.clip(rng.normal(4.8, 0.9), 3.0, 7.5))
            weave = draw_weave("Cyclist", rng)
            riders.append(
                Traveller("Cyclist", tuple(size), route, float(place), speed, speed, weave)
            )
            last = place
    return riders


def settle(roads: Roads, queue: list[Traveller]) -> list[Traveller]:
    """Speeds at which those who follow each other on one line brake comfortably at most.

    Args:
        roads: The routes.
        queue: Travellers on routes that share their beginning; sensor vehicles have free room
            around them.

    Returns:
        Travellers from front to back, without those that would overlap the one ahead.
    """
    settled: list[Traveller] = []
    limits = {traveller.route: roads.routes[traveller.route].limits() for traveller in queue}
    for traveller in sorted(queue, key=lambda each: -each.place):
        route, limit = roads.routes[traveller.route], limits[traveller.route]
        row = int(np.clip(traveller.place / SPACING, 0, len(limit) - 1))
        speed = min(traveller.speed, float(limit[row]))
        if settled:
            gap = settled[-1].rear - traveller.front
            if gap < _CLOSEST:
                continue
            speed = _comfortable(traveller, speed, gap, settled[-1].speed)
        if np.isfinite(route.gate) and not traveller.started:
            gap = route.gate - traveller.front + MANNERS[traveller.category][1] - 0.5
            speed = _comfortable(traveller, speed, max(gap, 0.1), 0.0)
        settled.append(traveller._replace(speed=speed))
    return settled


def _comfortable(traveller: Traveller, speed: float, gap: float, speed_ahead: float) -> float:
    """The speed, or a lower one, with which a traveller brakes little behind another."""
    manners = MANNERS[traveller.category]
    while speed > 0.3:
        felt = calm_interaction(speed, gap, speed - speed_ahead, *manners)
        if manners[2] * (1.0 - (speed / traveller.desired) ** 4 - felt) > -_BRAKING:
            return speed
        speed *= 0.93
    return 0.0
