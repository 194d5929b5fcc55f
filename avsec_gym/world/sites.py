"""Draw places: where a road bends, how the land rises, and which streets end at it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from avsec_gym.world.assets import Assets, seed_of
from avsec_gym.world.course import Course, course_from_curvature
from avsec_gym.world.ground import Ground
from avsec_gym.world.road import sections
from avsec_gym.world.section import CrossSection, Lane, Strip, Surface
from avsec_gym.world.site import SideStreet, Site, Style

BEHIND = 80.0
"""Metres of road before road coordinate 0, if the road is long enough."""

_SECTIONS: Mapping[Style, Callable[[np.random.Generator], CrossSection]] = {
    Style.CITY: sections.city_section,
    Style.RESIDENTIAL: sections.residential_section,
    Style.CAMPUS: sections.campus_section,
    Style.HIGHWAY: sections.highway_section,
    Style.RURAL: sections.rural_section,
}
_SHARPEST = {
    Style.CITY: 25.0,
    Style.RESIDENTIAL: 25.0,
    Style.CAMPUS: 40.0,
    Style.HIGHWAY: 400.0,
    Style.RURAL: 120.0,
}
"""Smallest radius of a bend, metres."""
_LARGEST_TURN = 1.2
"""The largest turn by which a road's heading departs from its mean at most, radians."""
_STREETS = {Style.CITY: 1.6, Style.RESIDENTIAL: 1.3, Style.CAMPUS: 0.7, Style.RURAL: 0.5}
"""Side streets for 200 m of road on average; never more than three."""


def draw_site(
    style: Style, rng: np.random.Generator, *, length: float, assets: Assets = Assets.ALL
) -> Site:
    """A place of a style: everything but its traffic and its scenery.

    Args:
        style: Style in which the site is built up.
        rng: The source of chance.
        length: Length of the main road, metres.  The first ego vehicle starts about 80 m after its
            beginning and should not come nearer to its end than about that.
        assets: The part of the assets that the place is made of.
    """
    section = _SECTIONS[style](rng)
    course = _course(style, section, rng, length)
    ground = _ground(style, course, rng)
    streets = _side_streets(style, course, section, rng)
    seed = seed_of(assets, int(rng.integers(2**31)))
    return Site(style, course, section, ground, seed, streets)


def _course(style: Style, section: CrossSection, rng: np.random.Generator, length: float) -> Course:
    """Straight stretches, gentle bends, now and then a sharp one; bends begin like clothoids."""
    count = int(length) + 1
    widest = max(abs(edge) for edge in section.edges)
    tightest = 1.0 / max(_SHARPEST[style], 1.6 * widest)
    curvature = np.zeros(count)
    if rng.random() < 0.75:
        place = float(rng.uniform(0.0, 80.0))
        while place < count:
            gentle = rng.random() < 0.8
            bend = tightest * (rng.uniform(0.02, 0.25) if gentle else rng.uniform(0.3, 1.0))
            turn = rng.uniform(0.05, 0.35) if gentle else rng.uniform(0.4, 1.4)
            reach = int(np.clip(turn / bend, 15.0, 300.0))
            curvature[int(place) : int(place) + reach] = rng.choice([-1.0, 1.0]) * min(
                bend, turn / reach
            )
            place += reach + float(rng.exponential(60.0)) + 20.0
    # Beyond its ends the road runs on straight.
    curvature[:20] = curvature[-20:] = 0.0
    ease = int(np.clip(0.5 / np.sqrt(tightest) * 4.0, 10.0, 80.0))
    window = np.hanning(ease + 2)[1:-1]
    curvature = np.convolve(np.pad(curvature, ease), window / window.sum(), "same")[ease:-ease]
    heading = np.cumsum(curvature)
    spread = float(np.abs(heading - heading.mean()).max())
    curvature *= min(1.0, _LARGEST_TURN / max(spread, 1e-9))
    start = -min(BEHIND, float(int(0.3 * length)))
    return course_from_curvature(
        curvature, start=start, pose=(0.0, 0.0, float(rng.uniform(-np.pi, np.pi)))
    )


def _ground(style: Style, course: Course, rng: np.random.Generator) -> Ground:
    """Slopes up to 3 % and gentle swells; highways are nearly flat."""
    flat = 0.25 if style == Style.HIGHWAY else 1.0
    slope = flat * np.clip(rng.normal(0.0, 0.008, 2), -0.02, 0.02)
    count = int(rng.integers(0, 6))
    near = course.points[rng.integers(0, len(course.points), count)]
    radius = rng.uniform(70.0, 180.0, count) / flat**0.5
    # A swell of height h and radius r is at most 0.61 h / r steep.
    height = flat * rng.uniform(-0.012, 0.012, count) * radius
    swells = np.column_stack([near + rng.normal(0.0, 40.0, (count, 2)), radius, height])
    return Ground((0.0, float(slope[0]), float(slope[1])), swells)


def _side_streets(
    style: Style, course: Course, section: CrossSection, rng: np.random.Generator
) -> tuple[SideStreet, ...]:
    """Ends of other streets where the main road is nearly straight, far from one another."""
    reach = course.end - course.start
    wanted = min(int(rng.poisson(_STREETS.get(style, 0.0) * reach / 200.0)), 3)
    bend = np.abs(np.gradient(course.headings, course.spacing))
    streets: list[SideStreet] = []
    for _ in range(8 * wanted):
        along, side = float(rng.uniform(course.start + 35.0, course.end - 35.0)), _side(rng)
        index = int((along - course.start) / course.spacing)
        close = any(
            abs(along - other.along) < (40.0 if side == other.side else 28.0) for other in streets
        )
        if len(streets) == wanted or close or bend[max(index - 20, 0) : index + 20].max() > 0.008:
            continue
        streets.append(_side_street(style, course, section, along, side, rng))
    return tuple(sorted(streets, key=lambda street: street.along))


def _side(rng: np.random.Generator) -> int:
    return 1 if rng.random() < 0.5 else -1


def _side_street(
    style: Style,
    course: Course,
    section: CrossSection,
    along: float,
    side: int,
    rng: np.random.Generator,
) -> SideStreet:
    """Nearly at a right angle, straight or gently bending, a lane each way."""
    x, y, heading = course.poses(along, 0.0)
    turn = side * 0.5 * np.pi + float(rng.normal(0.0, 0.08))
    edge = max(abs(each) for each in section.edges)
    count = int(edge + rng.uniform(35.0, 60.0)) + 1
    begin = edge + 12.0
    easing = np.clip((np.arange(count) - begin) / 15.0, 0.0, 1.0)
    curvature = easing * float(rng.normal(0.0, 0.008))
    line = course_from_curvature(curvature, pose=(float(x), float(y), float(heading + turn)))
    return SideStreet(along, side, line, side_section(style, rng), float(rng.uniform(5.0, 7.0)))


def side_section(style: Style, rng: np.random.Generator) -> CrossSection:
    """A side street's cross-section: two lanes, and kerbs and pavements in towns."""
    width = float(rng.uniform(2.8, 3.25))
    lanes = (Lane(-0.5 * width, 1, 8.3, width), Lane(0.5 * width, -1, 8.3, width))
    edge = width + 0.1
    road = Strip(Surface.ROAD, -edge, edge)
    if style in (Style.RURAL, Style.CAMPUS):
        return CrossSection((road,), (), lanes)
    pavement = float(rng.uniform(1.5, 2.5))
    right = (
        Strip(Surface.PAVEMENT, -edge - 0.14 - pavement, -edge - 0.14, 0.12, "slabs"),
        Strip(Surface.KERB, -edge - 0.14, -edge, 0.12, "kerb"),
    )
    left = tuple(
        Strip(strip.surface, -strip.left, -strip.right, strip.height, strip.material)
        for strip in right[::-1]
    )
    return CrossSection((*right, road, *left), (), lanes)
