"""Where people walk: lines on pavements that lead around whatever stands there, and crossings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from avsec_gym.geometry import Floats, rectangle_corners
from avsec_gym.world.section import Strip, Surface
from avsec_gym.world.site import Site, Style
from avsec_gym.world.traffic.population import Bystander
from avsec_gym.world.traffic.routes import SPACING, Route, along_course, join, stations

WIDTH = 0.75
"""Width of people on their lines, metres."""
_BESIDE = 1.0
"""Between neighbouring lines at least, metres."""
_EDGE = 0.45
"""Between the outermost lines and the pavement's edges, metres."""
_AROUND = 0.55
"""Between lines and whatever stands, metres."""
_BEYOND = 120.0
"""How far the lines go on beyond the site's ends, metres."""
_FORETHOUGHT = 2.0
"""Metres before an obstacle at which the way around it begins to matter."""
_ACROSS = 1.2
"""Room that a person needs to cross the road, metres to each side."""


@dataclass(frozen=True, eq=False)
class Pavement:
    """A strip for walking.

    Args:
        strip: The pavement's strip of the main road.
        side: Side of the carriageway: 1 to the left, -1 to the right.
        directions: Direction of each line on it, from right to left: 1 along the course, -1 against
            it.
        free: Right and left end of the free ground at the `stations`, shape (n, 2), metres.
    """

    strip: Strip
    side: int
    directions: tuple[int, ...]
    free: Floats

    @property
    def kerbside(self) -> int:
        """Index of the line that is nearest to the carriageway."""
        return 0 if self.side > 0 else len(self.directions) - 1

    def left(self, line: int) -> Floats:
        """Distance of a line to the left of the course at the `stations`, shape (n,)."""
        count = len(self.directions)
        share = (line + 0.5) / count if count == 1 else line / (count - 1)
        return self.free[:, 0] * (1 - share) + self.free[:, 1] * share


def pavements_of(site: Site, rng: np.random.Generator) -> list[Pavement]:
    """Every strip on which people walk; a campus without pavements has its greens."""
    surfaces = [Surface.PAVEMENT]
    strips = [strip for strip in site.section.strips if strip.surface in surfaces]
    if not strips and site.style == Style.CAMPUS:
        strips = [each for each in site.section.strips if each.surface == Surface.VERGE]
    right, left = site.section.carriageway
    pavements = []
    for strip in strips:
        room = strip.left - strip.right - 2 * _EDGE
        if room < 0.0 or right < strip.left < left:
            continue
        count = 1 + min(int(room / 1.1), 3)
        free = np.array([strip.right + _EDGE, strip.left - _EDGE])
        pavements.append(
            Pavement(
                strip,
                1 if strip.left > left else -1,
                tuple(rng.choice([-1, 1], count).tolist()),
                np.tile(free, (len(stations(site.course, _BEYOND)), 1)),
            )
        )
    return pavements


def make_way(
    site: Site, pavement: Pavement, bystanders: Sequence[Bystander]
) -> tuple[Pavement, list[int]]:
    """Lead the lines around whatever stands on a pavement.

    Returns:
        The pavement, and the indices of those around whom there is no way.
    """
    along = stations(site.course, _BEYOND)
    wanted = _BESIDE * (len(pavement.directions) - 1)
    free, refused = pavement.free.copy(), []
    for index, bystander in enumerate(bystanders):
        corners = rectangle_corners(
            bystander.pose, bystander.dimensions[2], bystander.dimensions[1]
        )
        begins, across = site.course.coordinates(*corners.T)
        right, left = across.min() - _AROUND, across.max() + _AROUND
        if left < free[:, 0].min() or right > free[:, 1].max():
            continue
        near = (along > begins.min() - _FORETHOUGHT) & (along < begins.max() + _FORETHOUGHT)
        narrowed = free.copy()
        # People pass where more room is left.
        if right - pavement.free[0, 0] > pavement.free[0, 1] - left:
            narrowed[near, 1] = np.minimum(narrowed[near, 1], right)
        else:
            narrowed[near, 0] = np.maximum(narrowed[near, 0], left)
        if (narrowed[:, 1] - narrowed[:, 0] < wanted).any():
            refused.append(index)
        else:
            free = narrowed
    return replace(
        pavement, free=np.stack([_smooth(free[:, 0], 1), _smooth(free[:, 1], -1)], -1)
    ), refused


def _smooth(edge: Floats, inwards: int) -> Floats:
    """A smooth edge on the inner side of a stepped one."""
    reach = 2
    padded = np.pad(edge * inwards, 3 * reach, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
    widened = windows.max(axis=1)
    weights = np.hanning(2 * reach + 3)[1:-1]
    return (
        np.asarray(np.convolve(widened, weights / weights.sum(), "same")[2 * reach : -2 * reach])
        * inwards
    )


def walking_route(site: Site, pavement: Pavement, line: int) -> Route:
    """Along a line of a pavement."""
    direction = pavement.directions[line]
    poses = along_course(site.course, pavement.left(line), direction, _BEYOND)
    length = SPACING * (len(poses) - 1)
    return Route(poses, WIDTH, shown=(_BEYOND, length - _BEYOND))


def crossing_route(
    site: Site, start: Pavement, goal: Pavement, along: float
) -> tuple[Route, float]:
    """From a pavement to the opposite one.

    Returns:
        The route, which begins some metres before the crossing, and the road coordinate of that
        beginning.
    """
    here = walking_route(site, start, start.kerbside).poses
    there = walking_route(site, goal, goal.kerbside).poses
    lefts = []
    for pavement in (start, goal):
        left = pavement.left(pavement.kerbside)
        lefts.append(float(np.interp(along, stations(site.course, _BEYOND), left)))
    count = int(abs(lefts[1] - lefts[0]) / SPACING) + 1
    sign = np.sign(lefts[1] - lefts[0])
    across = site.course.poses(
        along, lefts[0] + sign * SPACING * np.arange(count), sign * 0.5 * np.pi
    )
    poses, _, _ = join(_around(here, across[0], 12.0, 3.0), across, 1.3, 1.3)
    poses, _, _ = join(poses, _around(there, across[-1], 3.0, 300.0), 1.3, 1.3)
    _, left = site.course.coordinates(*poses[:, :2].T)
    leaves, arrives = (
        pavement.strip.left if pavement.side < 0 else pavement.strip.right
        for pavement in (start, goal)
    )
    gate = int(np.flatnonzero((left - leaves) * sign > -0.4)[0])
    clear = int(np.flatnonzero((left - arrives) * sign > 0.3)[0])
    begins, _ = site.course.coordinates(*poses[0, :2])
    return Route(poses, WIDTH, SPACING * gate, SPACING * clear + 0.5), float(begins)


def off_crossings(
    site: Site, bystanders: Sequence[Bystander], crossings: Sequence[float]
) -> tuple[Bystander, ...]:
    """Bystanders that stand on no crossing."""
    if not crossings or not bystanders:
        return tuple(bystanders)
    poses = np.array([bystander.pose for bystander in bystanders])
    sizes = np.array([bystander.dimensions for bystander in bystanders])
    corners = rectangle_corners(poses, sizes[:, 2], sizes[:, 1])
    along, _ = site.course.coordinates(corners[..., 0], corners[..., 1])
    low, high = along.min(axis=1) - _ACROSS, along.max(axis=1) + _ACROSS
    hit = ((low[:, None] < crossings) & (np.array(crossings) < high[:, None])).any(axis=1)
    return tuple(each for each, stands in zip(bystanders, hit.tolist(), strict=True) if not stands)


def _around(poses: Floats, place: Floats, before: float, behind: float) -> Floats:
    """The part of a line that passes a place."""
    nearest = int(((poses[:, :2] - place[:2]) ** 2).sum(axis=1).argmin())
    begin = max(nearest - int(before / SPACING), 0)
    return poses[begin : nearest + int(behind / SPACING) + 1]
