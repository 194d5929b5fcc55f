"""Vehicles and cyclists in the lanes, before red lights, and in side streets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.world.layouts.dimensions import CATEGORIES, CategoryMix, draw_dimensions
from avsec_gym.world.site import Site, Style
from avsec_gym.world.traffic.driving import bend_limits
from avsec_gym.world.traffic.population import EGO_SIZE, Traveller
from avsec_gym.world.traffic.roads import Roads
from avsec_gym.world.traffic.routes import SPACING
from avsec_gym.world.traffic.styles import Bustle

_CYCLIST = int(np.flatnonzero(CATEGORIES == "Cyclist")[0])
_SMALL = CategoryMix(Car=0.93, Van=0.07)
_BRAKING = 1.5
"""With which everybody could stop at time 0, m/s2."""


def draw_vehicle(
    bustle: Bustle, widest: float, rng: np.random.Generator
) -> tuple[str, tuple[float, float, float]]:
    """Category and size of a vehicle that fits into a lane."""
    codes = bustle.mix.draw(rng, 1)
    height, width, length = draw_dimensions(rng, codes)[0].tolist()
    return str(CATEGORIES[codes[0]]), (height, min(width, widest), length)


def draw_weave(category: str, rng: np.random.Generator) -> tuple[float, float, float]:
    """The small lateral motion of a driver, a cyclist, or a walker."""
    high, wave = {"Cyclist": (0.06, 11.0), "Pedestrian": (0.02, 5.0)}.get(category, (0.09, 75.0))
    return (
        high * float(rng.uniform(0.4, 1.2)),
        wave * float(rng.uniform(0.8, 1.4)),
        float(rng.uniform(0.0, 2 * np.pi)),
    )


def fill_lane(
    site: Site, roads: Roads, lane: int, bustle: Bustle, rng: np.random.Generator
) -> list[Traveller]:
    """Vehicles along a lane, some of which will turn off; those at the same places overlap none.

    Their speeds are those they want; see `settle`.
    """
    usual = site.section.lanes[lane].speed
    widest = max(site.section.lanes[lane].width - 0.35, 1.5)
    route = roads.routes[roads.lanes[lane]]
    turns = [turn for start, turn in roads.exits if start == roads.lanes[lane]]
    # In a jam everybody crawls.
    jam = float(rng.uniform(0.08, 0.35)) if rng.random() < 0.06 else 1.0
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
        vehicles.append(Traveller(category, size, index, place, 8.0, 10.0, weave))
        behind += size[2] + float(rng.uniform(2.0, 6.0))
    return vehicles


def fill_cycling(
    site: Site, roads: Roads, route: int, bustle: Bustle, rng: np.random.Generator
) -> list[Traveller]:
    """Cyclists on a cycle path or in the right part of a lane."""
    length = roads.routes[route].length
    count = int(rng.poisson(bustle.riders * length / 100.0))
    sizes = draw_dimensions(rng, np.full(count, _CYCLIST))
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


def ego_vehicle(
    site: Site, roads: Roads, lane: int, place: float, bustle: Bustle, rng: np.random.Generator
) -> Traveller:
    """A sensor car in a lane; now and then it stands at first, or stops on its way."""
    low, high = bustle.pace
    desired = site.section.lanes[lane].speed * float(rng.uniform(low, min(high, 1.0)))
    kind, begin, takes = rng.random(), rng.uniform(1.0, 25.0), rng.uniform(2.0, 8.0)
    pause = (np.inf, np.inf)
    if site.style != Style.HIGHWAY and kind < 0.2:
        pause = (0.0, takes) if kind < 0.1 else (begin, begin + takes)
    speed = 0.0 if pause[0] == 0.0 else desired
    weave = draw_weave("Car", rng)
    return Traveller(
        "Car", EGO_SIZE, roads.lanes[lane], place, speed, desired, weave, pause=pause, ego=True
    )


def settle(roads: Roads, queue: list[Traveller]) -> list[Traveller]:
    """Speeds at which those who follow each other on one line can all stop.

    Args:
        roads: The routes.
        queue: From back to front, on routes that share their beginning.

    Returns:
        The same without those who stand in another; the first of an overlapping pair leaves.
    """
    settled: list[Traveller] = []
    for one in sorted(queue, key=lambda each: -each.place):
        route = roads.routes[one.route]
        limit = bend_limits(np.gradient(route.poses[:, 2], SPACING), SPACING)
        bend = limit[min(max(int(one.place / SPACING), 0), len(limit) - 1)]
        speed = min(one.speed, float(bend))
        if settled:
            ahead = settled[-1]
            gap = ahead.rear - one.front - 2.5
            if gap < -1.0:
                continue
            speed = min(speed, float(np.sqrt(ahead.speed**2 + 2 * _BRAKING * max(gap, 0.0))))
            speed = min(speed, max(ahead.speed, max(gap, 0.0) / 1.2))
        if np.isfinite(route.gate) and not one.started:
            gap = max(route.gate - one.front - 0.5, 0.0)
            speed = min(speed, float(np.sqrt(2 * _BRAKING * gap)))
        settled.append(one._replace(speed=speed))
    return settled
