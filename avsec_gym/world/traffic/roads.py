"""The routes of vehicles and cyclists on a site: lanes, turns into side streets and out of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avsec_gym.geometry import Floats, Integers
from avsec_gym.world.section import Lane, Surface
from avsec_gym.world.site import SideStreet, Site, Style
from avsec_gym.world.traffic.routes import Route, along_course, join

_WIDTH, _RIDERS_WIDTH = 1.9, 0.7
"""Widths of vehicles and cyclists on their routes, metres."""
RIDERS_FROM_EDGE = 0.4
"""The distance from the middle of cyclists in a lane to its edge, metres."""
_FROM_EDGE = 1.2
"""Between the middles of lanes and the carriageway's edges at least, metres."""
_BEYOND, _BEYOND_HIGHWAY = 350.0, 600.0
"""How far traffic reaches beyond the site's ends, so that more comes after it, metres."""
_TURN_BEFORE, _TURN_BEHIND = 8.0, 4.0
"""Where turns begin and end: before the lanes meet, and behind the carriageway's edge, metres."""


@dataclass(frozen=True, eq=False)
class Roads:
    """Routes by what they are for: indices into `routes`.

    Args:
        routes: All routes.
        lanes: Route of each lane of the main road.
        exits: Lane, and route that turns from it into a side street.
        entries: Routes out of each side street onto the main road.
        cycling: Lines for cyclists, each with the lane in which it runs, -1 for cycle paths.
    """

    routes: list[Route]
    lanes: list[int]
    exits: list[tuple[int, int]]
    entries: list[list[int]]
    cycling: list[tuple[int, int]]

    def neighbours(self, lanes: tuple[Lane, ...], changing: bool) -> Integers:
        """Lanes to the left and right in the direction of travel, -1 for none, shape (R, 2)."""
        table = np.full((len(self.routes), 2), -1)
        for lane in range(len(lanes) - 1):
            beside = lane + 1
            if changing and lanes[lane].direction == lanes[beside].direction:
                right, left = (lane, beside) if lanes[lane].direction > 0 else (beside, lane)
                table[self.lanes[right], 0] = self.lanes[left]
                table[self.lanes[left], 1] = self.lanes[right]
        return table


def roads_of(site: Site) -> Roads:
    """Every vehicle's possible route."""
    roads = Roads([], [], [], [], [])
    right, left = site.section.carriageway
    for each in site.section.lanes:
        # Where cars park so close that a lane is narrow, its vehicles keep off them.
        middle = float(np.clip(each.left, right + _FROM_EDGE, left - _FROM_EDGE))
        roads.lanes.append(_add(roads, main_route(site, middle, each.direction)))
    for street in site.side_streets:
        roads.entries.append([])
        for direction in (1, -1):
            _add_turns(roads, site, street, direction)
    for left, direction, lane in _cycling_lines(site):
        route = main_route(site, left, direction)
        roads.cycling.append((_add(roads, replace(route, width=_RIDERS_WIDTH)), lane))
    return roads


def main_route(site: Site, left: float, direction: int) -> Route:
    """A vehicle's route along the main road, beyond both ends of the site."""
    margin = _BEYOND_HIGHWAY if site.style == Style.HIGHWAY else _BEYOND
    poses = along_course(site.course, left, direction, margin)
    route = Route(poses, _WIDTH)
    ends = site.course.poses([site.course.start, site.course.end], left)
    first, last = sorted(route.nearest(*end[:2]) for end in ends)
    return replace(route, shown=(first, last))


def walking_edge(site: Site, side: int) -> float:
    """How far from the course the outermost pavement or cycle path of a side reaches, metres."""
    edges = [site.section.carriageway[0 if side < 0 else 1] * side]
    for strip in site.section.strips:
        if strip.surface in (Surface.PAVEMENT, Surface.CYCLE_PATH):
            edges.append(max(strip.left * side, strip.right * side))
    return max(edges)


def _add(roads: Roads, route: Route) -> int:
    roads.routes.append(route)
    return len(roads.routes) - 1


def _add_turns(roads: Roads, site: Site, street: SideStreet, direction: int) -> None:
    """Between a side street and the lane of a direction that is nearest to it."""
    lanes = site.section.lanes
    there = [i for i in range(len(lanes)) if lanes[i].direction == direction]
    if not there:
        return
    index = max(there, key=lambda i: lanes[i].left * street.side)
    lane, main = lanes[index], roads.routes[roads.lanes[index]]
    edge = site.section.carriageway[0 if street.side < 0 else 1]
    between = np.linspace(lane.left, edge, 30)[:-1]
    if (site.section.surface(between) != Surface.ROAD).any():
        return
    outer = walking_edge(site, street.side)
    to_edge = (edge - lane.left) * street.side + _TURN_BEHIND
    away, towards = _side_lanes(street)
    poses, begin, end = join(main.poses, away, _TURN_BEFORE, to_edge)
    clear = end + max(outer - abs(edge) - _TURN_BEHIND, 0.0) + 0.5
    far = street.course.poses(street.course.end, 0.0)[:2]
    route = Route(poses, _WIDTH, begin + 1.0, clear)
    shown = (main.shown[0], route.nearest(*far))
    roads.exits.append((roads.lanes[index], _add(roads, replace(route, shown=shown))))

    poses, _, end = join(towards, main.poses, to_edge, _TURN_BEFORE)
    route = Route(poses, _WIDTH)
    stop = street.course.poses(outer + 0.8, 0.0)[:2]
    last = route.nearest(
        *site.course.poses(site.course.end if direction > 0 else site.course.start, lane.left)[:2]
    )
    route = replace(
        route, gate=route.nearest(*stop), clear=end + 1.0, shown=(route.nearest(*far), last)
    )
    roads.entries[-1].append(_add(roads, route))


def _side_lanes(street: SideStreet) -> tuple[Floats, Floats]:
    """Lines away from the main road and towards it, beyond the street's far end."""
    lanes = street.section.lanes
    right, left = street.section.carriageway
    away = next((lane.left for lane in lanes if lane.direction > 0), 0.75 * right + 0.25 * left)
    back = next((lane.left for lane in lanes if lane.direction < 0), 0.25 * right + 0.75 * left)
    leaving = along_course(street.course, away, 1, 60.0)
    coming = along_course(street.course, back, -1, 60.0)
    # Nothing of the margin at the main road's end.
    first = Route(leaving, _WIDTH).nearest(*street.course.poses(0.0, away)[:2])
    return leaving[int(2 * max(first - 20.0, 0.0)) :], coming


def _cycling_lines(site: Site) -> list[tuple[float, int, int]]:
    """Lines on which people cycle: left of the course, direction, lane or -1 beside the road."""
    if site.style == Style.HIGHWAY:
        return []
    lines: list[tuple[float, int, int]] = []
    for strip in site.section.strips:
        if strip.surface == Surface.CYCLE_PATH:
            middle, width = 0.5 * (strip.right + strip.left), strip.left - strip.right
            if width >= 2.0:
                lines += [(middle - 0.25 * width, 1, -1), (middle + 0.25 * width, -1, -1)]
            else:
                lines.append((middle, 1 if middle < 0 else -1, -1))
    lanes = site.section.lanes
    for direction in (1, -1):
        there = [i for i in range(len(lanes)) if lanes[i].direction == direction]
        if there and not any(direction == line[1] for line in lines):
            outer = min(there, key=lambda i: lanes[i].left * direction)
            beside = direction * (0.5 * lanes[outer].width - RIDERS_FROM_EDGE)
            lines.append((lanes[outer].left - beside, direction, outer))
    return lines
