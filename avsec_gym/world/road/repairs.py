"""Patches, trenches, joints and cracks."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.road.canvas import Colour, RoadCanvas, offset, rectangle, wear_tile
from avsec_gym.world.section import Strip, Surface
from avsec_gym.world.site import Site, Style

_FRESH: tuple[Colour, ...] = ((62, 63, 66), (74, 74, 76), (86, 86, 87))
_OLD: tuple[Colour, ...] = ((146, 143, 137), (134, 132, 128))
_TAR: Colour = (34, 34, 36)
_CRACK: Colour = (38, 36, 34)
_AGE = {
    Style.CITY: 0.7,
    Style.RESIDENTIAL: 1.0,
    Style.CAMPUS: 0.6,
    Style.HIGHWAY: 0.25,
    Style.RURAL: 0.5,
}


def paint_repairs(canvas: RoadCanvas, site: Site, rng: np.random.Generator) -> None:
    """All of a road's repairs; how many depends on its age, which is drawn."""
    age = _AGE[site.style] * float(rng.gamma(2.0, 0.5))
    right, left = site.section.carriageway
    road = [strip for strip in site.section.strips if strip.surface == Surface.ROAD]
    if all(strip.material in ("slabs", "cobbles") for strip in road):
        return
    _resurfaced(canvas, site, rng, age)
    _trenches(canvas, rng, age, right, left)
    walked = [strip for strip in site.section.strips if strip.surface == Surface.PAVEMENT]
    for strip in (*road, *walked):
        if strip.material == "asphalt":
            _patches(canvas, rng, age, strip)
            _cracks(canvas, rng, age, strip)
        if strip.material == "concrete":
            _slab_joints(canvas, rng, strip)
    _joints(canvas, site, rng, age)


def _resurfaced(canvas: RoadCanvas, site: Site, rng: np.random.Generator, age: float) -> None:
    """A lane or the whole road, over some length, in another asphalt."""
    right, left = site.section.carriageway
    for _ in range(rng.poisson(0.5 * age)):
        first = rng.uniform(canvas.start, canvas.end)
        last = first + rng.uniform(15.0, 80.0)
        lane = site.section.lanes[int(rng.integers(len(site.section.lanes)))]
        half = 0.5 * lane.width
        whole = rng.random() < 0.4
        edges = (right, left) if whole else (lane.left - half, lane.left + half)
        colour = (_FRESH, _OLD)[int(rng.random() < 0.4)][int(rng.integers(2))]
        area = rectangle(first, last, max(edges[0], right), min(edges[1], left))
        _patch(canvas, rng, area, colour, rng.uniform(0.25, 0.6))


def _trenches(
    canvas: RoadCanvas, rng: np.random.Generator, age: float, right: float, left: float
) -> None:
    """Where pipes were laid: long narrow strips along or across."""
    length = canvas.end - canvas.start
    for _ in range(rng.poisson(age * length / 70.0)):
        first = rng.uniform(canvas.start, canvas.end)
        width = rng.uniform(0.5, 1.1)
        if rng.random() < 0.5:
            side = rng.uniform(right, left - width)
            area = rectangle(first, first + rng.uniform(5.0, 40.0), side, side + width)
        else:
            ends = np.sort(rng.choice([right, 0.5 * (right + left), left], 2, replace=False))
            area = rectangle(first, first + width, *ends)
            area[:, 0] += rng.normal(0.0, 0.5) * (area[:, 1] > area[:, 1].mean())
        _patch(canvas, rng, area, _either(rng), rng.uniform(0.2, 0.65))


def _patches(canvas: RoadCanvas, rng: np.random.Generator, age: float, strip: Strip) -> None:
    """Holes filled."""
    wide = strip.left - strip.right
    area = wide * (canvas.end - canvas.start)
    for _ in range(rng.poisson(age * area / 210.0)):
        first = rng.uniform(canvas.start, canvas.end)
        size = min(rng.uniform(0.4, 2.2), wide)
        side = rng.uniform(strip.right, strip.left - size)
        area_ = rectangle(first, first + rng.uniform(0.6, 4.0), side, side + size)
        area_ += rng.normal(0.0, 0.05, area_.shape)
        _patch(canvas, rng, area_, _either(rng), rng.uniform(0.35, 0.8))


def _either(rng: np.random.Generator) -> Colour:
    choice = _FRESH if rng.random() < 0.7 else _OLD
    return choice[int(rng.integers(len(choice)))]


def _patch(
    canvas: RoadCanvas, rng: np.random.Generator, corners: Floats, colour: Colour, opacity: float
) -> None:
    canvas.fill([corners], colour, opacity, grain=offset(rng))
    if rng.random() < 0.6:
        canvas.stroke(
            [corners],
            rng.uniform(0.02, 0.06),
            _TAR,
            rng.uniform(0.35, 0.75),
            closed=True,
            wear=(wear_tile(2), offset(rng)),
        )


def _joints(canvas: RoadCanvas, site: Site, rng: np.random.Generator, age: float) -> None:
    """Seams between lanes, laid one after the other."""
    for lane in site.section.lanes:
        if rng.random() > 0.5 + 0.4 * age:
            continue
        along = np.arange(canvas.start, canvas.end + 2.0, 2.0)
        side = lane.left + 0.5 * lane.width + rng.normal(0.0, 0.12)
        left = side + 0.02 * np.cumsum(rng.normal(0.0, 0.4, len(along)))
        width, wear = (0.05, 1) if rng.random() < 0.3 else (0.025, 3)
        line = np.stack([along, np.clip(left, side - 0.15, side + 0.15)], axis=-1)
        canvas.stroke([line], width, _TAR, 0.6, wear=(wear_tile(wear), offset(rng)))


def _slab_joints(canvas: RoadCanvas, rng: np.random.Generator, strip: Strip) -> None:
    """Concrete is cast in fields of five metres; tar fills what is between."""
    if strip.left - strip.right < 1.0:
        return
    ends = [strip.right, strip.left]
    lines = [
        np.array([(at, end) for end in ends])
        for at in np.arange(canvas.start + rng.uniform(0.0, 5.0), canvas.end, 5.0)
    ]
    canvas.stroke(lines, 0.03, _TAR, 0.6, wear=(wear_tile(2), offset(rng)))


def _cracks(canvas: RoadCanvas, rng: np.random.Generator, age: float, strip: Strip) -> None:
    """Fine branching ones, and those filled with tar."""
    length = canvas.end - canvas.start
    wide = strip.left - strip.right
    if wide < 1.0:
        return
    for sealed in (False, True):
        count = rng.poisson(age * length * wide / (420.0 if sealed else 130.0))
        lines = []
        for _ in range(count):
            start = np.array(
                [rng.uniform(canvas.start, canvas.end), rng.uniform(strip.right, strip.left)]
            )
            across = rng.random() < 0.45
            direction = (0.5 * np.pi if across else 0.0) + rng.normal(0.0, 0.25)
            steps = int(rng.uniform(8, 30 if across else 60))
            lines += _branching(rng, start, direction, steps, 0 if sealed else 2)
        inside = [line for line in (_clipped(line, strip) for line in lines) if len(line) > 1]
        width, colour, opacity = (0.07, _TAR, 0.8) if sealed else (0.012, _CRACK, 0.55)
        for line in inside:
            canvas.stroke([line], width, colour, opacity * rng.uniform(0.6, 1.0))


def _branching(
    rng: np.random.Generator, start: Floats, direction: float, steps: int, depth: int
) -> list[Floats]:
    """A random walk with an inclination, and some that leave it."""
    turns = rng.normal(0.0, 0.32, steps)
    headings = direction + turns + 0.3 * np.cumsum(0.3 * turns)
    moves = rng.uniform(0.08, 0.3, steps)[:, None]
    walk = start + np.cumsum(moves * np.stack([np.cos(headings), np.sin(headings)], -1), axis=0)
    lines = [np.concatenate([start[None], walk])]
    if depth:
        for at in rng.integers(0, steps, rng.poisson(steps / 16.0)):
            side = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 1.3)
            shorter = max(4, int(steps * rng.uniform(0.2, 0.5)))
            lines += _branching(rng, walk[at], headings[at] + side, shorter, depth - 1)
    return lines


def _clipped(line: Floats, strip: Strip) -> Floats:
    """Up to where it leaves the strip."""
    outside = (line[:, 1] < strip.right) | (line[:, 1] > strip.left)
    return line[: int(outside.argmax())] if outside.any() else line
