"""Fill a site with all that is there at time 0: vehicles, cyclists, people."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.world.layouts.view import without_overlaps
from avsec_gym.world.site import Site, Style
from avsec_gym.world.traffic.egos import EGO_SPACING, sensor_vehicles
from avsec_gym.world.traffic.parking import out_of_the_way, parked_rows, poses_of
from avsec_gym.world.traffic.pavements import (
    Pavement,
    make_way,
    off_crossings,
    pavements_of,
    walking_route,
)
from avsec_gym.world.traffic.people import (
    companion,
    crosser,
    crossings,
    standing_groups,
    walkers,
)
from avsec_gym.world.traffic.population import Bystander, Population, Traveller
from avsec_gym.world.traffic.pulling_out import leave_parking
from avsec_gym.world.traffic.roads import RIDERS_FROM_EDGE, Roads, roads_of
from avsec_gym.world.traffic.routes import SPACING
from avsec_gym.world.traffic.state import NARROW, begin, network_of
from avsec_gym.world.traffic.styles import STYLES, Bustle
from avsec_gym.world.traffic.vehicles import (
    fill_cycling,
    fill_lane,
    fill_side_street,
    settle,
)

_AROUND_EGO = 8.0
"""Free metres in the lane before and behind an ego vehicle at first."""
_PASSING = 0.82
"""The distance from a vehicle's side to the middle of a cyclist that it passes, metres."""
_FARTHEST_ASIDE = 0.5
"""The farthest from the middle of the lane, metres."""
_RED_LIGHT = 0.25
"""Probability on a city street."""
_JAM = 0.06
"""Probability that one direction's traffic crawls."""
_FROM_MOUTH = 25.0
"""Between a red light and side streets, metres."""
_COUPLES = 0.3
"""Share of the walkers with a second person beside them."""


def populate(
    site: Site,
    rng: np.random.Generator,
    *,
    egos: int = 1,
    density: float | None = None,
    spacing: tuple[float, float] = EGO_SPACING,
) -> Population:
    """Draw who is on a site at time 0: sensor vehicles, traffic, parked cars, people.

    Args:
        site: The place.
        rng: The source of chance.
        egos: Number of vehicles that carry sensors, 1 or more. The first drives along the course;
            the others are before or behind it, oncoming, or parked.
        density: Amount of traffic on top of what chance draws; about 1 as usual for the style, 0
            for no road user but the ego vehicles; None for 1 and, now and then, none of a kind at
            all.
        spacing: Least and greatest distance of the other sensor vehicles from the first, metres.

    Returns:
        A population in which no two overlap, and every traveller can stop in time.
    """
    # In an order in which each group finds the room that those before it left.
    bustle = _tonight(STYLES[site.style], density, rng)
    roads = roads_of(site)
    bystanders = out_of_the_way(parked_rows(site, bustle, rng), roads.routes)
    pavements = pavements_of(site, rng)
    places = crossings(site, bustle, pavements, rng)
    bystanders = off_crossings(site, bystanders, places)
    drivers, bystanders, parked_egos = sensor_vehicles(
        site, roads, bystanders, bustle, egos, rng, spacing
    )
    traffic = _traffic(site, roads, drivers, bustle, rng)
    leaving, bystanders = leave_parking(site, roads, bystanders, parked_egos, bustle, rng)
    groups = off_crossings(site, standing_groups(site, pavements, bustle, rng), places)
    bystanders = (*bystanders, *out_of_the_way(groups, roads.routes))
    pavements, bystanders = _make_way(site, pavements, bystanders, parked_egos)
    people = _people(site, roads, pavements, places, traffic, bustle, rng)
    return _assemble(
        site, roads, [*traffic, *leaving, *people], bystanders, len(drivers), parked_egos, rng
    )


def _tonight(usual: Bustle, density: float | None, rng: np.random.Generator) -> Bustle:
    """The style's numbers, scaled by chance."""
    vehicles, people, riders = rng.gamma([1.5, 0.9, 0.8]) / [1.5, 0.9, 0.8]
    parked = usual.parked * rng.uniform(0.3, 1.3)
    absent = rng.random(4) < [0.1, 0.15, 0.3, 0.15]
    vehicles, people, riders, parked = np.where(absent, 0.0, [vehicles, people, riders, parked])
    if density is not None:
        vehicles, people, riders = (max(each, 0.3) * density for each in (vehicles, people, riders))
        parked *= min(density, 1.0)
    return replace(
        usual,
        flow=usual.flow / vehicles if vehicles > 0.01 else np.inf,
        parked=float(np.clip(parked, 0.0, 0.97)),
        waiting=usual.waiting * float(min(vehicles, 2.0)),
        walkers=usual.walkers * float(people),
        groups=usual.groups * float(people),
        riders=usual.riders * float(riders),
    )


def _traffic(
    site: Site,
    roads: Roads,
    drivers: list[Traveller],
    bustle: Bustle,
    rng: np.random.Generator,
) -> list[Traveller]:
    """Vehicles and cyclists with speeds at which all can follow; the ego vehicles first."""
    found: list[Traveller] = []
    lights = _red_lights(site, roads, rng)
    jams = np.where(rng.random(2) < _JAM, rng.uniform(0.1, 0.4, 2), 1.0)
    for lane, route in enumerate(roads.lanes):
        jam = float(jams[int(site.section.lanes[lane].direction > 0)])
        own = [
            ego._replace(speed=ego.speed * jam, desired=ego.desired * jam)
            for ego in drivers
            if ego.route == route
        ]
        queue = _lane_queue(site, roads, lane, own, bustle, jam, rng)
        queue = [_before_light(traveller, lights, roads) for traveller in queue]
        found += settle(roads, queue)
    for riding, beside in roads.cycling:
        if beside < 0:
            found += settle(roads, fill_cycling(site, roads, riding, bustle, rng))
    for street in range(len(site.side_streets)):
        found += settle(roads, fill_side_street(roads, street, bustle, rng))
    return sorted(
        found, key=lambda traveller: traveller.ego if traveller.ego >= 0 else len(drivers)
    )


def _lane_queue(
    site: Site,
    roads: Roads,
    lane: int,
    egos: list[Traveller],
    bustle: Bustle,
    jam: float,
    rng: np.random.Generator,
) -> list[Traveller]:
    """Vehicles and cyclists in a lane, with room around its ego vehicles."""
    vehicles = fill_lane(site, roads, lane, bustle, jam, rng)
    riders: list[Traveller] = []
    for riding, beside in roads.cycling:
        if beside == lane:
            riders += fill_cycling(site, roads, riding, bustle, rng)
    free = [
        traveller
        for traveller in [*vehicles, *riders]
        if all(
            traveller.rear > ego.front + _AROUND_EGO or traveller.front < ego.rear - _AROUND_EGO
            for ego in egos
        )
    ]
    queue = [*egos, *free]
    return [_aside(site, lane, traveller) for traveller in queue] if riders else queue


def _aside(site: Site, lane: int, traveller: Traveller) -> Traveller:
    """Drivers keep left of cyclists, and pass them, where the lane is wide enough."""
    beside = 0.5 * site.section.lanes[lane].width - RIDERS_FROM_EDGE
    aside = 0.5 * traveller.dimensions[1] + _PASSING - beside
    narrow = traveller.category == "Cyclist" or aside > _FARTHEST_ASIDE
    return traveller if narrow else traveller._replace(left=max(aside, 0.0))


def _red_lights(site: Site, roads: Roads, rng: np.random.Generator) -> dict[int, tuple[int, float]]:
    """Copies of the lanes' routes with a red light, and when it turns green, by their originals."""
    length = site.course.end - site.course.start
    along = site.course.start + length * float(rng.uniform(0.3, 0.7))
    mouths = [abs(along - street.along) for street in site.side_streets]
    likely = _RED_LIGHT if site.style == Style.CITY else 0.0
    if rng.random() > likely or min(mouths, default=np.inf) < _FROM_MOUTH:
        return {}
    green = float(rng.uniform(2.0, 25.0))
    lights = {}
    for index in [*roads.lanes, *(route for route, lane in roads.cycling if lane >= 0)]:
        route = roads.routes[index]
        x, y, _ = site.course.poses(along, 0.0)
        gate = route.nearest(float(x), float(y)) - 4.0
        roads.routes.append(replace(route, gate=gate, clear=gate + 5.0))
        lights[index] = (len(roads.routes) - 1, green)
    return lights


def _before_light(
    traveller: Traveller, lights: dict[int, tuple[int, float]], roads: Roads
) -> Traveller:
    if traveller.route not in lights:
        return traveller
    route, green = lights[traveller.route]
    if traveller.front > roads.routes[route].gate - 1.0:
        return traveller
    return traveller._replace(route=route, opens=green, polite=False)


def _make_way(
    site: Site,
    pavements: list[Pavement],
    bystanders: tuple[Bystander, ...],
    egos: list[Bystander],
) -> tuple[list[Pavement], tuple[Bystander, ...]]:
    """Pavements with lines around the bystanders there, and the bystanders that leave a way."""
    ways = []
    for pavement in pavements:
        way, refused = make_way(site, pavement, bystanders)
        bystanders = tuple(
            each for i, each in enumerate(bystanders) if i not in refused or each in egos
        )
        ways.append(way)
    return ways, bystanders


def _people(
    site: Site,
    roads: Roads,
    pavements: list[Pavement],
    places: list[float],
    traffic: list[Traveller],
    bustle: Bustle,
    rng: np.random.Generator,
) -> list[Traveller]:
    """People who walk along the pavements and across the road."""
    people: list[Traveller] = []
    for along in places:
        route, person = crosser(site, pavements, along, len(roads.routes), rng)
        if person.started and not _can_stop(site, roads, traffic, along):
            waits = route.gate - 0.5 * person.dimensions[2] - 0.05
            person = person._replace(place=waits, speed=0.0, started=False)
        roads.routes.append(route)
        people.append(person)
    for pavement in pavements:
        companions: list[Traveller] = []
        for line, direction in enumerate(pavement.directions):
            route = walking_route(site, pavement, line)
            roads.routes.append(route)
            index = len(roads.routes) - 1
            mean = bustle.walkers / len(pavement.directions)
            alone = settle(roads, [*companions, *walkers(index, route.length, mean, rng)])
            people += alone
            beside = pavement.directions[line + 1 : line + 2]
            together = (rng.random(len(alone)) < _COUPLES) & (beside == (direction,))
            companions = [
                companion(walker, index + 1, rng)
                for walker, two in zip(alone, together.tolist(), strict=True)
                if two
            ]
    return people


def _can_stop(site: Site, roads: Roads, traffic: list[Traveller], along: float) -> bool:
    """Whether all vehicles and cyclists can stop before a person who crosses."""
    for traveller in traffic:
        route = roads.routes[traveller.route]
        row = int(np.clip(traveller.place / SPACING, 0, len(route.poses) - 1))
        x, y, heading = route.poses[row]
        there, _ = site.course.coordinates(x, y)
        road = float(site.course.poses(there, 0.0)[2])
        gap = (along - float(there)) * np.sign(np.cos(heading - road)) - 0.5 * traveller.dimensions[
            2
        ]
        if (
            -traveller.dimensions[2] - 2.0
            < gap - 1.5
            < traveller.speed**2 / 4.0 + 0.7 * traveller.speed + 2.0
        ):
            return False
    return True


def _assemble(
    site: Site,
    roads: Roads,
    travellers: list[Traveller],
    bystanders: tuple[Bystander, ...],
    drivers: int,
    parked_egos: list[Bystander],
    rng: np.random.Generator,
) -> Population:
    """Leave out actors that overlap another; the sensor vehicles stay."""
    routes = tuple(roads.routes)
    network = network_of(routes)
    poses = begin(network, tuple(travellers)).poses
    # Sensor vehicles come first: of two that overlap, the earlier one stays.
    standing = sorted(bystanders, key=lambda bystander: bystander not in parked_egos)
    every: list[Traveller | Bystander] = [*travellers[:drivers], *standing[: len(parked_egos)]]
    every += [*travellers[drivers:], *standing[len(parked_egos) :]]
    ahead = len(parked_egos)
    where = np.concatenate(
        [poses[:drivers], poses_of(standing[:ahead]), poses[drivers:], poses_of(standing[ahead:])]
    )
    sizes = np.array([actor.dimensions for actor in every])
    room = np.where(sizes[:, 1] > NARROW, 0.3, 0.5)
    stays = without_overlaps(where, sizes[:, 2] + room, sizes[:, 1] + 0.1)
    kept = [actor for actor, stay in zip(every, stays.tolist(), strict=True) if stay]
    moving = tuple(actor for actor in kept if isinstance(actor, Traveller))
    still = tuple(actor for actor in kept if isinstance(actor, Bystander))
    egos = (*range(drivers), *range(len(moving), len(moving) + ahead))
    changing = site.style == Style.HIGHWAY
    return Population(
        routes,
        roads.neighbours(site.section.lanes, changing),
        moving,
        still,
        egos,
        rng.integers(0, 2**31, len(kept)),
        rng.random(len(kept)),
    )
