"""Parked cars that pull out into the traffic."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.geometry import wrap_angle
from avsec_gym.world.site import Site
from avsec_gym.world.traffic.parking import out_of_the_way
from avsec_gym.world.traffic.population import Bystander, Traveller
from avsec_gym.world.traffic.roads import Roads
from avsec_gym.world.traffic.routes import SPACING, Route, splice
from avsec_gym.world.traffic.styles import Bustle


def leave_parking(
    site: Site,
    roads: Roads,
    bystanders: tuple[Bystander, ...],
    egos: list[Bystander],
    bustle: Bustle,
    rng: np.random.Generator,
) -> tuple[list[Traveller], tuple[Bystander, ...]]:
    """Parked cars that wait to pull out, and those that stay parked."""
    leaving: list[Traveller] = []
    lanes = site.section.lanes
    for _ in range(min(int(rng.poisson(0.7 * bustle.parked)), 2)):
        candidates = [car for car in bystanders if car.category == "Car" and car not in egos]
        if not candidates:
            break
        chosen = candidates[int(rng.integers(len(candidates)))]
        x, y, heading = chosen.pose
        along, left = site.course.coordinates(x, y)
        road = float(site.course.poses(along, 0.0)[2])
        direction = 1 if np.cos(heading - road) > 0 else -1
        lane = min(range(len(lanes)), key=lambda i: abs(lanes[i].left - left))
        aslant = abs(wrap_angle(heading - road - (0.0 if direction > 0 else np.pi))) > 0.15
        if lanes[lane].direction != direction or aslant or abs(lanes[lane].left - left) > 4.0:
            continue
        route, place = _pull_out(chosen, roads.routes[roads.lanes[lane]])
        around = tuple(bystander for bystander in bystanders if bystander is not chosen)
        way = replace(route, poses=route.poses[int(place / SPACING) :])
        free = out_of_the_way(around, [way])
        if any(all(ego is not bystander for bystander in free) for ego in egos):
            continue
        bystanders = free
        roads.routes.append(route)
        desired = lanes[lane].speed * float(rng.uniform(*bustle.pace))
        leaving.append(
            Traveller(
                chosen.category,
                chosen.dimensions,
                len(roads.routes) - 1,
                place,
                0.0,
                desired,
                (0.0, 75.0, 0.0),
                opens=float(rng.exponential(6.0)),
            )
        )
    return leaving, bystanders


def _pull_out(bystander: Bystander, lane: Route) -> tuple[Route, float]:
    """A route from a parked vehicle's place into a lane, and its place on it at the beginning."""
    x, y, heading = bystander.pose
    behind = np.arange(-6.0, 1.0 + SPACING, SPACING)
    start = np.stack(
        [x + behind * np.cos(heading), y + behind * np.sin(heading), np.full(len(behind), heading)],
        axis=-1,
    )
    onto = int((lane.nearest(x, y) + 15.0) / SPACING)
    poses, _, end = splice(start, lane.poses[onto:])
    gate = 6.0 + 0.5 * bystander.dimensions[2] + 0.2
    shown = (-np.inf, lane.shown[1] - lane.nearest(x, y) + 6.0)
    return Route(poses, lane.width, gate, end + 1.0, shown), 6.0
