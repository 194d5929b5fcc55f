"""Iron in the road: manhole covers, drains, caps of water and gas valves."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np

from avsec_gym.world.road.canvas import RoadCanvas, offset, rectangle
from avsec_gym.world.road.junction import Mouth
from avsec_gym.world.section import Surface
from avsec_gym.world.site import Site, Style

_IRON = (66.0, 63.0, 60.0)
_DEEP = (24.0, 23.0, 22.0)
_RING = (142.0, 138.0, 130.0)
_PATCH = (72.0, 72.0, 74.0)


def paint_covers(
    canvas: RoadCanvas, site: Site, openings: Sequence[Mouth], rng: np.random.Generator
) -> None:
    """Manholes in the lanes, drains along kerbs, small caps: where there are houses."""
    if site.style in (Style.HIGHWAY, Style.RURAL):
        return
    length = canvas.end - canvas.start
    lanes = site.section.lanes
    for _ in range(rng.poisson(length / 32.0)):
        lane = lanes[int(rng.integers(len(lanes)))]
        left = lane.left + rng.normal(0.0, 0.5)
        _manhole(canvas, rng, rng.uniform(canvas.start, canvas.end), left)
    right_edge, left_edge = site.section.carriageway
    for _ in range(rng.poisson(length / 16.0)):
        place = (rng.uniform(canvas.start, canvas.end), rng.uniform(right_edge, left_edge))
        _disc(canvas, *place, float(rng.uniform(0.07, 0.1)), _IRON, 0.9)
        _disc(canvas, *place, 0.05, _DEEP, 0.35)
    for strip in site.section.strips:
        if strip.surface == Surface.PAVEMENT:
            for _ in range(rng.poisson(length / 25.0)):
                first = rng.uniform(canvas.start, canvas.end)
                side = rng.uniform(strip.right + 0.2, strip.left - 0.6)
                size = rng.uniform(0.3, 0.8, 2)
                lid = rectangle(first, first + size[0], side, side + min(size[1], 0.5))
                colour = _RING if rng.random() < 0.5 else _IRON
                canvas.fill([lid], colour, 0.8, grain=offset(rng))
                canvas.stroke([lid], 0.02, _DEEP, 0.6, closed=True)
    _drains(canvas, site, openings, rng)


def _drains(
    canvas: RoadCanvas, site: Site, openings: Sequence[Mouth], rng: np.random.Generator
) -> None:
    """Gratings in the gutter where the kerb rises."""
    strips = site.section.strips
    low = (Surface.ROAD, Surface.PARKING)
    for one, two in pairwise(strips):
        if (one.surface in low) == (two.surface in low) or one.height == two.height:
            continue
        kerb, side = (one.left, -1.0) if one.surface in low else (two.right, 1.0)
        for place in np.arange(canvas.start + rng.uniform(2.0, 18.0), canvas.end, 22.0):
            along = float(place + rng.uniform(-4.0, 4.0))
            if not any(m.paved.bounds[0] - 1 < along < m.paved.bounds[2] + 1 for m in openings):
                _grating(canvas, along, kerb + side * 0.22)


def _grating(canvas: RoadCanvas, along: float, left: float) -> None:
    """Half a metre long, a third wide, with bars across."""
    frame = rectangle(along - 0.27, along + 0.27, left - 0.19, left + 0.19)
    canvas.fill([frame], _IRON)
    slots = [
        rectangle(at - 0.02, at + 0.02, left - 0.14, left + 0.14)
        for at in along + np.linspace(-0.2, 0.2, 6)
    ]
    canvas.fill(slots, _DEEP, 0.95)


def _manhole(canvas: RoadCanvas, rng: np.random.Generator, along: float, left: float) -> None:
    if rng.random() < 0.45:
        half = rng.uniform(0.5, 0.7)
        patch = rectangle(along - half, along + half, left - half, left + half)
        canvas.fill([patch], _PATCH, rng.uniform(0.3, 0.7), grain=offset(rng))
    _disc(canvas, along, left, 0.39, _IRON, 0.95)
    _disc(canvas, along, left, 0.345, _DEEP, 0.45)
    # The lid: iron around a core of concrete, or iron with a pattern.
    if rng.random() < 0.6:
        _disc(canvas, along, left, 0.33, _IRON, 0.9)
        _disc(canvas, along, left, 0.23, _RING, 0.8)
    else:
        _disc(canvas, along, left, 0.33, _IRON, 0.8)
        bars = [
            rectangle(along - half, along + half, left + at - 0.02, left + at + 0.02)
            for at, half in ((-0.2, 0.2), (-0.1, 0.28), (0.0, 0.3), (0.1, 0.28), (0.2, 0.2))
        ]
        canvas.fill(bars, _DEEP, 0.5)


def _disc(
    canvas: RoadCanvas,
    along: float,
    left: float,
    radius: float,
    colour: tuple[float, float, float],
    opacity: float,
) -> None:
    centre = canvas.pixels(along, left)
    pixels = radius * canvas.scale
    corner = np.floor(centre - pixels - 1).astype(int)
    side = int(2 * pixels) + 4
    mask = np.zeros((side, side), np.uint8)
    middle = np.round((centre - corner - 0.5) * 16).astype(int).tolist()
    cv2.circle(mask, middle, round(pixels * 16), 255, -1, cv2.LINE_AA, 4)
    canvas.lay(mask, int(corner[0]), int(corner[1]), colour, opacity)
