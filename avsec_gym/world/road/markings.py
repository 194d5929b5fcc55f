"""Painted markings: lines, crossings, give-way lines, bays, arrows, symbols."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.road.canvas import RoadCanvas, offset, rectangle, wear_tile
from avsec_gym.world.road.junction import Mouth
from avsec_gym.world.road.symbols import ARROWS, STROKES, placed
from avsec_gym.world.section import Line, LineKind, Strip, Surface
from avsec_gym.world.site import Site, Style

_WHITE = (214.0, 213.0, 206.0)
_DASHES = {False: (3.0, 6.0), True: (6.0, 12.0)}
"""Metres of paint and of gap, in streets and on highways."""


def paint_markings(
    canvas: RoadCanvas, site: Site, openings: Sequence[Mouth], rng: np.random.Generator
) -> None:
    """All markings of a road, worn alike; on highways they are kept fresh."""
    section = site.section
    wear = int(rng.choice(4, p=[0.25, 0.4, 0.25, 0.1]))
    if site.style == Style.HIGHWAY:
        wear = min(wear, 1)
    for line in section.lines:
        shapes = _line(canvas, line, site.style == Style.HIGHWAY, openings)
        _paint(canvas, rng, shapes, wear)
    for mouth in openings:
        _paint(canvas, rng, _give_way(mouth, rng), min(wear + 1, 4))
    for strip in section.strips:
        if strip.surface == Surface.PARKING and strip.material == "asphalt" and rng.random() < 0.6:
            _paint(canvas, rng, _bays(canvas, strip, openings, rng), min(wear + 1, 4))
        if strip.surface == Surface.CYCLE_PATH:
            _cycle_path(canvas, strip, openings, rng, wear)
    if site.style in (Style.CITY, Style.RESIDENTIAL):
        _crossing(canvas, site, openings, rng, wear)
    if section.lines and site.style == Style.CITY and len(section.lanes) > 2:
        _arrows(canvas, site, openings, rng, wear)
    if site.style == Style.RESIDENTIAL and rng.random() < 0.25:
        for lane in section.lanes:
            along = rng.uniform(canvas.start, canvas.end)
            _symbol(canvas, rng, "30", (float(along), lane.left), lane.direction, wear)


def _paint(
    canvas: RoadCanvas, rng: np.random.Generator, shapes: Sequence[Floats], wear: int
) -> None:
    canvas.fill(shapes, _WHITE, wear=(wear_tile(wear), offset(rng)))


def _line(canvas: RoadCanvas, line: Line, highway: bool, openings: Sequence[Mouth]) -> list[Floats]:
    """The pieces of a line."""
    half = 0.5 * line.width
    if line.kind == LineKind.DASHED:
        paint, gap = _DASHES[highway]
        first = np.floor(canvas.start / (paint + gap)) * (paint + gap)
        starts = np.arange(first, canvas.end, paint + gap)
        return [rectangle(s, s + paint, line.left - half, line.left + half) for s in starts]
    middles = [line.left]
    if line.kind == LineKind.DOUBLE:
        middles = [line.left - line.width, line.left + line.width]
    shapes = []
    for middle in middles:
        for first, last, broken in _stretches(canvas, middle, openings):
            length = 1.5 if broken else last - first
            shapes += [
                rectangle(s, min(s + length, last), middle - half, middle + half)
                for s in np.arange(first, last, 2.0 * length)
            ]
    return shapes


def _stretches(
    canvas: RoadCanvas, left: float, openings: Sequence[Mouth]
) -> list[tuple[float, float, bool]]:
    """Where a line runs: first, last, and whether it is broken as it lies across a mouth."""
    at, stretches = canvas.start, []
    for mouth in sorted(openings, key=lambda each: each.street.along):
        first, right, last, far = mouth.paved.bounds
        if right - 0.8 < left < far + 0.8 and first > at:
            stretches += [(at, first, False), (first, last, True)]
            at = last
    return [*stretches, (at, canvas.end, False)]


def _give_way(mouth: Mouth, rng: np.random.Generator) -> list[Floats]:
    """A broken line, or a stop line, across the half of the side street that leads here."""
    side, street = mouth.street.side, mouth.street
    _, right, _, far = mouth.paved.bounds
    near = (right if side > 0 else far) + side * 0.6
    lane_right, lane_left = street.section.carriageway
    half = lane_left if side > 0 else -lane_right
    first, last = street.along - side * half, street.along
    first, last = min(first, last), max(first, last)
    if rng.random() < 0.2:
        return [rectangle(first, last, near - 0.25, near + 0.25)]
    starts = np.arange(first, last - 0.3, 0.75)
    return [rectangle(s, s + 0.5, near - 0.125, near + 0.125) for s in starts]


def _bays(
    canvas: RoadCanvas, strip: Strip, openings: Sequence[Mouth], rng: np.random.Generator
) -> list[Floats]:
    """Lines between bays: along the road, or across it where the strip is deep."""
    deep = strip.left - strip.right > 3.8
    length = 2.5 if deep else 5.5
    side = np.sign(strip.left + strip.right)
    closed = [mouth.paved.bounds[::2] for mouth in openings if mouth.street.side == side]
    places = [
        place
        for place in np.arange(canvas.start + rng.uniform(0.0, length), canvas.end, length)
        if not any(first - 1.0 < place < last + 1.0 for first, last in closed)
    ]
    return [rectangle(p - 0.06, p + 0.06, strip.right + 0.1, strip.left - 0.1) for p in places]


def _cycle_path(
    canvas: RoadCanvas,
    strip: Strip,
    openings: Sequence[Mouth],
    rng: np.random.Generator,
    wear: int,
) -> None:
    """Narrow lines at its edges when it is beside a pavement, and bicycles now and then."""
    if strip.height > 0:
        shown = rng.random() < 0.5
        for edge in (strip.right + 0.06, strip.left - 0.06):
            line = Line(LineKind.SOLID, edge)
            if shown:
                _paint(canvas, rng, _line(canvas, line, False, openings), wear)
    middle = 0.5 * (strip.left + strip.right)
    for along in np.arange(canvas.start + rng.uniform(5.0, 40.0), canvas.end, 45.0):
        direction = 1 if middle < 0 else -1
        _symbol(canvas, rng, "bicycle", (float(along), middle), direction, wear)


def _crossing(
    canvas: RoadCanvas,
    site: Site,
    openings: Sequence[Mouth],
    rng: np.random.Generator,
    wear: int,
) -> None:
    """Seldom a zebra crossing, away from side streets, with lines to stop at."""
    if rng.random() > (0.16 if site.style == Style.CITY else 0.05):
        return
    along = float(rng.uniform(canvas.start + 20.0, canvas.end - 20.0))
    if any(abs(mouth.street.along - along) < 18.0 for mouth in openings):
        return
    right, left = site.section.carriageway
    stripes = np.arange(right + 0.35, left - 0.5, 1.0)
    length = float(rng.uniform(3.0, 4.0))
    shapes = [rectangle(along, along + length, s, s + 0.5) for s in stripes]
    _paint(canvas, rng, shapes, wear)


def _arrows(
    canvas: RoadCanvas,
    site: Site,
    openings: Sequence[Mouth],
    rng: np.random.Generator,
    wear: int,
) -> None:
    """Arrows on the lanes before side streets."""
    for mouth in openings:
        for lane in site.section.lanes:
            along = mouth.street.along - lane.direction * rng.uniform(16.0, 22.0)
            turning = "left" if mouth.street.side == lane.direction else "right"
            outer = abs(lane.left - site.section.carriageway[int(mouth.street.side > 0)])
            kind = turning if outer < 1.2 * lane.width else "straight"
            arrow = placed(ARROWS[kind], along, lane.left, lane.direction)
            _paint(canvas, rng, [arrow], wear)


def _symbol(
    canvas: RoadCanvas,
    rng: np.random.Generator,
    name: str,
    place: tuple[float, float],
    direction: int,
    wear: int,
) -> None:
    width, strokes = STROKES[name]
    canvas.stroke(
        [placed(stroke, *place, direction) for stroke in strokes],
        width,
        _WHITE,
        wear=(wear_tile(wear), offset(rng)),
    )
