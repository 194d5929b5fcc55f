"""Typical German cross-sections for each style of place, and sections around given lanes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from avsec_gym.world.road.roadside import RoadsidePart, parking, roadside
from avsec_gym.world.section import CrossSection, Lane, Line, LineKind, Strip, Surface
from avsec_gym.world.site import Style

_SPEEDS = {
    Style.CITY: 13.9,
    Style.RESIDENTIAL: 8.3,
    Style.CAMPUS: 5.6,
    Style.HIGHWAY: 33.0,
    Style.RURAL: 25.0,
}
_NARROWEST_MEDIAN = 1.5
"""Lanes less far apart have a line between them, metres."""
_CAR_WIDTH = 2.0
"""Room that a parked car takes, with its mirrors, metres."""


def city_section(rng: np.random.Generator) -> CrossSection:
    """One or two lanes each way, parking, broad pavements, sometimes a cycle path."""
    width = float(rng.choice([3.0, 3.25, 3.5]))
    each_way = 2 if rng.random() < 0.3 else 1
    return section_for_lanes(
        _both_ways(each_way, each_way, width),
        width,
        Style.CITY,
        rng,
        parked_right=_parked(rng, -1, 0.6, -(each_way - 0.5) * width),
        parked_left=_parked(rng, 1, 0.6, (each_way + 0.5) * width),
    )


def residential_section(rng: np.random.Generator) -> CrossSection:
    """A narrow street, often with parking on one side, mostly without lines."""
    width = float(rng.choice([2.75, 3.0]))
    lanes = _both_ways(1, 1, width) if rng.random() < 0.75 else [0.0]
    return section_for_lanes(
        lanes,
        width,
        Style.RESIDENTIAL,
        rng,
        parked_right=_parked(rng, -1, 0.55, -0.5 * width),
        parked_left=_parked(rng, 1, 0.45, (len(lanes) - 0.5) * width),
    )


def campus_section(rng: np.random.Generator) -> CrossSection:
    """A broad light way without kerbs, between lawns and trees."""
    width = float(rng.uniform(2.75, 3.5))
    lanes = [0.0, width] if rng.random() < 0.6 else [0.0]
    right = _parked(rng, -1, 0.3, -0.5 * width)
    return section_for_lanes(lanes, width, Style.CAMPUS, rng, parked_right=right)


def highway_section(rng: np.random.Generator) -> CrossSection:
    """Two or three lanes each way, hard shoulders, a median for the guard rails."""
    count, width = int(rng.integers(2, 4)), float(rng.choice([3.5, 3.75]))
    own = width * (np.arange(count) - int(rng.integers(0, 2)))
    median = float(rng.uniform(3.5, 4.5)) + 1.0
    return _divided(rng, own, own[-1] + width + median + width * np.arange(count), width, True)


def rural_section(rng: np.random.Generator) -> CrossSection:
    """Two lanes between edge lines and verges, sometimes a cycle path beside them."""
    width = float(rng.choice([3.0, 3.25, 3.5]))
    return section_for_lanes([0.0, width], width, Style.RURAL, rng)


def section_for_lanes(
    lane_offsets: Sequence[float],
    lane_width: float,
    style: Style,
    rng: np.random.Generator,
    parked_right: float | None = None,
    parked_left: float | None = None,
) -> CrossSection:
    """A section around given lanes and parked rows.

    Args:
        lane_offsets: Middles of the lanes, metres to the left of the course; at least one.
            Lanes more than half a lane to the left of 0 are oncoming, but on highways only
            those beyond a gap.
        lane_width: Largest width of a lane, metres; lanes closer than that are narrower.
        style: Style in which the place is built up.
        rng: The source of chance.
        parked_right: Outer side of the cars parked on the right, metres to the left of the course
            (so negative); None without any.  Highways have none.
        parked_left: Outer side of those on the left, metres.
    """
    offsets = np.sort(np.asarray(lane_offsets, float))
    steps = np.diff(offsets)
    if style == Style.HIGHWAY:
        # Beyond the widest gap, if it leaves room for a median, traffic comes towards us.
        split = int(np.argmax(steps)) + 1 if steps.size and steps.max() > lane_width + 2.0 else 0
        own, oncoming = (offsets[:split], offsets[split:]) if split else (offsets, offsets[:0])
        return _divided(rng, own, oncoming, lane_width, False)
    width = float(min([lane_width, *steps.tolist()]))
    lanes = tuple(
        Lane(float(offset), -1 if offset > 0.5 * width else 1, _SPEEDS[style], width)
        for offset in offsets
    )
    margin = 0.35 if style == Style.RURAL else 0.1
    right, left = offsets[0] - 0.5 * width - margin, offsets[-1] + 0.5 * width + margin
    # Cars may park so close that they narrow the outer lanes.
    beside_right = beside_left = 0.0
    if parked_right is not None:
        right = max(right, min(parked_right + _CAR_WIDTH, offsets[0] - 0.2))
        beside_right = right - parked_right + 0.15
    if parked_left is not None:
        left = min(left, max(parked_left - _CAR_WIDTH, offsets[-1] + 0.2))
        beside_left = parked_left - left + 0.15
    carriageway, material = _carriageway(rng, lanes, style, right, left)
    lines = () if material == "slabs" else _lines(rng, lanes, style, right, left)
    sides = [roadside(rng, style, depth, material) for depth in (beside_right, beside_left)]
    return CrossSection(
        (*_outwards(right, -1, sides[0]), *carriageway, *_outwards(left, 1, sides[1])),
        lines,
        lanes,
    )


def _both_ways(own: int, oncoming: int, width: float) -> list[float]:
    """Lane middles; the ego vehicle takes the lane beside the oncoming ones."""
    lanes = width * (np.arange(own + oncoming) - (own - 1))
    return [float(offset) for offset in lanes]


def _parked(rng: np.random.Generator, side: int, share: float, edge: float) -> float | None:
    depth = parking(rng)
    return edge + side * depth if rng.random() < share else None


def _outwards(edge: float, side: int, parts: Sequence[RoadsidePart]) -> list[Strip]:
    """Strips beyond an edge of the carriageway, in order from right to left."""
    ends = edge + side * np.cumsum([0.0, *(part.width for part in parts)])
    strips = [
        Strip(part.surface, min(pair), max(pair), part.height, part.material)
        for part, pair in zip(parts, pairwise(ends.tolist()), strict=True)
    ]
    return strips if side > 0 else strips[::-1]


def _carriageway(
    rng: np.random.Generator, lanes: Sequence[Lane], style: Style, right: float, left: float
) -> tuple[list[Strip], str]:
    """Of one piece, or with a raised median in a gap between the lanes."""
    material = "asphalt"
    if style == Style.CAMPUS:
        material = str(rng.choice(["asphalt", "concrete", "slabs"]))
    strips, begin = [], float(right)
    for one, two in pairwise(lanes):
        near, far = one.left + 0.5 * one.width + 0.3, two.left - 0.5 * two.width - 0.3
        if far - near > _NARROWEST_MEDIAN:
            strips += [
                Strip(Surface.ROAD, begin, near, 0.0, material),
                Strip(Surface.KERB, near, near + 0.14, 0.12, "kerb"),
                Strip(Surface.VERGE, near + 0.14, far - 0.14, 0.12, "grass"),
                Strip(Surface.KERB, far - 0.14, far, 0.12, "kerb"),
            ]
            begin = far
    return [*strips, Strip(Surface.ROAD, begin, float(left), 0.0, material)], material


def _lines(
    rng: np.random.Generator, lanes: Sequence[Lane], style: Style, right: float, left: float
) -> tuple[Line, ...]:
    painted = {Style.CITY: 0.85, Style.RESIDENTIAL: 0.2, Style.RURAL: 1.0}.get(style, 0.1)
    if rng.random() > painted:
        return ()
    lines = []
    if style == Style.RURAL:
        lines.append(Line(LineKind.SOLID, right + 0.25))
    for one, two in pairwise(lanes):
        kind = LineKind.DASHED
        apart = two.left - two.width / 2 - one.left - one.width / 2
        if one.direction != two.direction:
            if len(lanes) > 2 and rng.random() < 0.5:
                kind = LineKind.DOUBLE
            elif rng.random() < 0.2:
                kind = LineKind.SOLID
        if apart - 0.6 <= _NARROWEST_MEDIAN:
            lines.append(Line(kind, 0.5 * (one.left + two.left)))
        else:
            lines += [
                Line(LineKind.SOLID, one.left + 0.5 * one.width),
                Line(LineKind.SOLID, two.left - 0.5 * two.width),
            ]
    if style == Style.RURAL:
        lines.append(Line(LineKind.SOLID, left - 0.25))
    return tuple(lines)


def _divided(
    rng: np.random.Generator,
    own: np.ndarray,
    oncoming: np.ndarray,
    width: float,
    wide_lines: bool,
) -> CrossSection:
    """A highway; what lies between the carriageways is a grass median."""
    shoulder, inner = float(rng.uniform(2.5, 3.0)), 0.5
    material = "concrete" if rng.random() < 0.15 else "asphalt"
    verge = float(rng.uniform(2.5, 4.0))
    thick = 0.25 if wide_lines else 0.2
    right, left = own[0] - 0.5 * width, own[-1] + 0.5 * width
    edges = [right - shoulder, left + inner]
    lines = [Line(LineKind.SOLID, right - 0.5 * thick, thick)]
    lines += [Line(LineKind.DASHED, float(o) + 0.5 * width, 0.15) for o in own[:-1]]
    lines.append(Line(LineKind.SOLID, left + 0.08, 0.15))
    if len(oncoming):
        near, far = oncoming[0] - 0.5 * width, oncoming[-1] + 0.5 * width
        edges += [near - inner, far + shoulder]
        lines.append(Line(LineKind.SOLID, near - 0.08, 0.15))
        lines += [Line(LineKind.DASHED, float(o) - 0.5 * width, 0.15) for o in oncoming[1:]]
        lines.append(Line(LineKind.SOLID, far + 0.5 * thick, thick))
    borders = [edges[0] - verge, *edges, edges[-1] + verge]
    strips = [
        Strip(
            Surface.ROAD if number % 2 else Surface.VERGE,
            float(begin),
            float(end),
            0.0,
            material if number % 2 else "grass",
        )
        for number, (begin, end) in enumerate(pairwise(borders))
    ]
    speeds = _SPEEDS[Style.HIGHWAY] + 3.0 * np.arange(-1, len(own) + len(oncoming))
    lanes = [Lane(float(o), 1, float(v), width) for o, v in zip(own, speeds, strict=False)]
    lanes += [
        Lane(float(o), -1, float(v), width)
        for o, v in zip(oncoming, speeds[: len(oncoming)][::-1], strict=True)
    ]
    return CrossSection(tuple(strips), tuple(lines), tuple(lanes))
