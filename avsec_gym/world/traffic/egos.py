"""The vehicles that carry sensors: in the traffic, oncoming, or parked near one another."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.site import Site, Style
from avsec_gym.world.traffic.parking import poses_of
from avsec_gym.world.traffic.population import Bystander, Traveller
from avsec_gym.world.traffic.roads import Roads
from avsec_gym.world.traffic.styles import Bustle
from avsec_gym.world.traffic.vehicles import draw_weave

EGO_SIZE = (1.50, 1.80, 4.70)
"""Height, width, length of the estate cars that carry sensors, metres."""
_EGO_FROM_START = 80.0
"""Metres from the site's beginning to the first ego vehicle, if the site is long enough."""
EGO_SPACING = (15.0, 60.0)
"""Ego spacing from the first ego vehicle to the others, metres, unless asked otherwise."""
_APART = 15.0
"""Metres between two ego vehicles in one lane: enough to stop."""
_TRIES = 30
"""Tries to find a place for the next one."""


def sensor_vehicles(
    site: Site,
    roads: Roads,
    bystanders: tuple[Bystander, ...],
    bustle: Bustle,
    egos: int,
    rng: np.random.Generator,
    spacing: tuple[float, float] = EGO_SPACING,
) -> tuple[list[Traveller], tuple[Bystander, ...], list[Bystander]]:
    """The ego vehicles that drive, all bystanders, and the ego vehicles among these.

    The others stand or drive at `spacing` metres (least, most) from the first one.
    """
    # The first ego vehicle drives along the course, in the lane nearest to it.
    lanes = site.section.lanes
    forward = [i for i in range(len(lanes)) if lanes[i].direction > 0]
    own = min(forward, key=lambda i: abs(lanes[i].left))
    reach = site.course.end - site.course.start
    along = site.course.start + min(_EGO_FROM_START, 0.3 * reach) + float(rng.uniform(-5.0, 5.0))
    drivers = [_at(site, roads, own, along, bustle, rng)._replace(ego=0)]
    parked: list[Bystander] = []
    against = [i for i in range(len(lanes)) if lanes[i].direction < 0]
    taken, tries = {own: [along]}, _TRIES
    # The others park near it, drive against it, or drive before or behind it.
    while len(drivers) + len(parked) < egos:
        kind, away = rng.random(), float(rng.uniform(*spacing))
        spots = _parked_near(site, bystanders, parked, along, spacing)
        if kind < 0.25 and spots:
            chosen = spots[int(rng.integers(len(spots)))]
            ego = Bystander("Car", EGO_SIZE, chosen.pose)
            bystanders = tuple(ego if each is chosen else each for each in bystanders)
            parked.append(ego)
            continue
        lane = int(rng.choice(against)) if kind < 0.6 and against else int(rng.choice(forward))
        there = along + away * (1 if lane in against or rng.random() < 0.5 else -1)
        others = taken.setdefault(lane, [])
        if any(abs(there - other) < _APART for other in others):
            if tries := tries - 1:
                continue
            # No room is left near the first one: the row of ego vehicles grows longer.
            tries, there = _TRIES, max(others) + _APART
        others.append(there)
        drivers.append(_at(site, roads, lane, there, bustle, rng)._replace(ego=len(drivers)))
    return drivers, bystanders, parked


def _ego_vehicle(
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
    return Traveller("Car", EGO_SIZE, roads.lanes[lane], place, speed, desired, weave, pause=pause)


def _at(
    site: Site, roads: Roads, lane: int, along: float, bustle: Bustle, rng: np.random.Generator
) -> Traveller:
    x, y, _ = site.course.poses(along, site.section.lanes[lane].left)
    place = roads.routes[roads.lanes[lane]].nearest(float(x), float(y))
    return _ego_vehicle(site, roads, lane, place, bustle, rng)


def _parked_near(
    site: Site,
    bystanders: tuple[Bystander, ...],
    taken: list[Bystander],
    along: float,
    spacing: tuple[float, float],
) -> list[Bystander]:
    """Parked cars whose place an ego vehicle may have."""
    if not bystanders:
        return []
    poses = poses_of(bystanders)
    places, _ = site.course.coordinates(poses[:, 0], poses[:, 1])
    near = (np.abs(places - along) > spacing[0]) & (np.abs(places - along) < spacing[1])
    return [
        bystander
        for bystander, fits in zip(bystanders, near.tolist(), strict=True)
        if fits and bystander.dimensions[2] > EGO_SIZE[2] - 0.6 and bystander not in taken
    ]
