"""People on pavements: walkers, groups that stand, and people who cross the road."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.layouts.dimensions import CATEGORIES, draw_dimensions
from avsec_gym.world.site import Site
from avsec_gym.world.traffic.pavements import Pavement, crossing_route
from avsec_gym.world.traffic.population import Bystander, Traveller
from avsec_gym.world.traffic.routes import Route
from avsec_gym.world.traffic.styles import Bustle
from avsec_gym.world.traffic.vehicles import draw_weave

_PEDESTRIAN = int(np.flatnonzero(CATEGORIES == "Pedestrian")[0])
_WIDEST = 0.8
_STANDING_LENGTH = (0.4, 0.65)
"""Standing length of people who do not stride, metres."""
_SPEEDS = (0.8, 1.8)
"""Slowest and fastest walkers, m/s."""
_APART = 1.6
"""Between people who walk one behind the other, metres at least."""


def draw_person(rng: np.random.Generator) -> tuple[float, float, float]:
    """Height, width and length of a walking person."""
    height, width, length = draw_dimensions(rng, np.array([_PEDESTRIAN]))[0].tolist()
    return height, min(width, _WIDEST), length


def standing_groups(
    site: Site, pavements: list[Pavement], bustle: Bustle, rng: np.random.Generator
) -> tuple[Bystander, ...]:
    """People who stand on the houses' side of pavements, alone or facing each other."""
    people = []
    length = site.course.end - site.course.start
    for pavement in pavements:
        strip = pavement.strip
        for _ in range(int(rng.poisson(bustle.groups * length / 100.0))):
            along = float(rng.uniform(site.course.start + 2.0, site.course.end - 2.0))
            outer = strip.left if pavement.side > 0 else strip.right
            count = 1 + int(rng.poisson(1.2))
            radius = 0.0 if count == 1 else 0.45 + 0.13 * count
            left = outer - pavement.side * (0.4 + radius)
            turn = float(rng.uniform(0.0, 2 * np.pi))
            for angle in turn + 2 * np.pi * np.arange(count) / count:
                x, y, _ = site.course.poses(along, left)
                height, width, _ = draw_person(rng)
                size = (height, min(width, 0.65), float(rng.uniform(*_STANDING_LENGTH)))
                pose = (
                    float(x + radius * np.cos(angle)),
                    float(y + radius * np.sin(angle)),
                    float(angle + (np.pi if count > 1 else 0.0) + rng.normal(0.0, 0.25)),
                )
                people.append(Bystander("Pedestrian", size, pose))
    return tuple(people)


def walkers(route: int, length: float, count: float, rng: np.random.Generator) -> list[Traveller]:
    """People on one line, `count` of them for 100 m; some stop now and then."""
    people: list[Traveller] = []
    places = np.sort(rng.uniform(0.0, length, int(rng.poisson(count * length / 100.0))))
    for place in places.tolist():
        if people and place - people[-1].place < _APART:
            continue
        people.append(_walker(route, place, rng))
    return people


def crossings(
    site: Site, bustle: Bustle, pavements: list[Pavement], rng: np.random.Generator
) -> list[float]:
    """Road coordinates at which people cross, not near side streets or one another."""
    length = site.course.end - site.course.start
    if len({pavement.side for pavement in pavements}) < 2:
        return []
    mean = bustle.crossing * bustle.walkers * length / 100.0
    places: list[float] = []
    for along in rng.uniform(site.course.start, site.course.end, int(rng.poisson(mean))).tolist():
        mouths = [abs(along - street.along) for street in site.side_streets]
        if min([abs(along - other) for other in places] + mouths, default=np.inf) > 14.0:
            places.append(along)
    return places


def crosser(
    site: Site, pavements: list[Pavement], along: float, index: int, rng: np.random.Generator
) -> tuple[Route, Traveller]:
    """A person who crosses the road: on the way to the kerb, waiting there, or half across."""
    side = int(rng.choice([-1, 1]))
    start = _nearest(pavements, side)
    goal = _nearest(pavements, -side)
    route, _ = crossing_route(site, start, goal, along)
    person = _walker(index, 0.0, rng)._replace(
        pause=(np.inf, np.inf),
        opens=float(rng.exponential(4.0)),
        polite=bool(rng.random() < 0.6),
        weave=(0.0, 5.0, 0.0),
    )
    waits = route.gate - 0.5 * person.dimensions[2] - 0.05
    kind = rng.random()
    if kind < 0.4:
        return route, person._replace(place=waits, speed=0.0)
    if kind < 0.7:
        return route, person._replace(place=float(rng.uniform(1.0, max(waits - 1.0, 1.5))))
    across = float(rng.uniform(route.gate + 1.0, route.clear))
    return route, person._replace(place=across, started=True)


def companion(walker: Traveller, route: int, rng: np.random.Generator) -> Traveller:
    """A second person, who walks beside the first, on the next line."""
    weave = draw_weave("Pedestrian", rng)
    return walker._replace(dimensions=draw_person(rng), route=route, weave=weave)


def _nearest(pavements: list[Pavement], side: int) -> Pavement:
    """The pavement of a side that is nearest to the carriageway."""
    there = [pavement for pavement in pavements if pavement.side == side]
    return min(there, key=lambda pavement: abs(pavement.strip.left + pavement.strip.right))


def _walker(route: int, place: float, rng: np.random.Generator) -> Traveller:
    speed = float(np.clip(rng.normal(1.35, 0.2), *_SPEEDS))
    begin = float(rng.choice([0.0, rng.uniform(0.0, 40.0)]))
    pause = (
        (begin, begin + float(rng.uniform(2.0, 12.0))) if rng.random() < 0.2 else (np.inf, np.inf)
    )
    return Traveller(
        "Pedestrian",
        draw_person(rng),
        route,
        place,
        0.0 if pause[0] == 0.0 else speed,
        speed,
        draw_weave("Pedestrian", rng),
        pause=pause,
    )
