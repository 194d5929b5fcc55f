"""What traffic and weather leave on a road: tracks, dirt, oil, leaves."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.world.road.canvas import Mask, RoadCanvas, offset
from avsec_gym.world.road.junction import Mouth
from avsec_gym.world.section import CrossSection, Surface
from avsec_gym.world.site import Site, Style
from avsec_gym.world.textures.noise import fractal_noise

_COARSE = 8
"""Tracks and dirt are drawn so many times coarser than the picture, ..."""
_COARSER = 4
"""... their noise even so many times coarser along the road."""
_STAINED = {"concrete": 0.07, "slabs": 0.05, "cobbles": 0.05, "clinker": 0.05}
_LEAST = 0.085
"""How much blotches darken a surface: textures repeat every few metres, and these hide it."""
_DARK = np.array([44.0, 44.0, 46.0])
_DUST = np.array([160.0, 149.0, 130.0])
_OIL = (30.0, 29.0, 30.0)
_EDGES = {
    "grass": (84.0, 84.0, 50.0),
    "soil": (108.0, 92.0, 72.0),
    "gravel": (138.0, 130.0, 114.0),
    "leaves": (112.0, 88.0, 58.0),
}
"""What creeps over an edge."""
_BLOTCHES = 1024
_CREEP = 0.35
"""How far at most, metres."""
_WEEDS = np.array([(72, 80, 42), (98, 94, 56), (60, 66, 38)])
_LEAVES = np.array([(170, 132, 66), (142, 98, 52), (186, 160, 84), (112, 76, 48), (150, 120, 60)])


def paint_tracks(
    canvas: RoadCanvas, site: Site, openings: Sequence[Mouth], rng: np.random.Generator
) -> None:
    """Bands where wheels run and oil drips, dust where no wheel rolls; the canvas is empty."""
    # Painted on a coarser lattice: rows across the road, columns along it.
    height, width = (size // _COARSE for size in canvas.picture.shape[:2])
    left = canvas.top - (np.arange(height) + 0.5) * _COARSE / canvas.scale
    along = canvas.start + (np.arange(width) + 0.5) * _COARSE / canvas.scale
    cells = max(2.0, (canvas.end - canvas.start) / 12.0)
    patchy, cloudy = (
        cv2.resize(
            fractal_noise(
                rng,
                height,
                width // _COARSER,
                cells=finer * cells,
                octaves=octaves,
                persistence=persistence,
            ),
            (width, height),
        )
        for finer, octaves, persistence in ((1, 5, 0.7), (2, 4, 0.8))
    )

    # Dark: wheel tracks and oil in the middle of each lane, and blotches by surface.
    dark = np.zeros(height)
    for lane in site.section.lanes:
        wheels, middle = rng.uniform(-0.05, 0.16), rng.uniform(0.0, 0.17)
        wheels = wheels * min(1.0, lane.speed / 12.0)
        track = rng.uniform(0.68, 0.78)
        for place, strength, spread in ((-track, wheels, 0.24), (track, wheels, 0.24)):
            dark += strength * np.exp(-0.5 * ((left - lane.left - place) / spread) ** 2)
        dark += middle * np.exp(-0.5 * ((left - lane.left) / 0.33) ** 2)
    surface = site.section.surface(left)
    drivable = np.isin(surface, (Surface.ROAD, Surface.PARKING))
    shade = np.where(drivable, dark, 0.0)[:, None] * (1.0 + 0.3 * patchy) + 0.022 * cloudy
    stained = np.array([_STAINED.get(s.material, _LEAST) for s in site.section.strips])
    borders = [strip.right for strip in site.section.strips[1:]]
    shade += stained[np.searchsorted(borders, left)][:, None] * _blotches(height, width, rng)

    # Light: dust along the edges, and wherever the shade would brighten.
    dirt = rng.uniform(0.25, 0.6) * np.exp(-_edge_distance(site.section, left) / 0.32)[:, None]
    dirt = dirt * _closed(openings, along, left) * np.clip(0.8 + 0.7 * patchy, 0.0, 2.0)
    dust = np.clip(dirt + np.maximum(-shade, 0.0), 0.0, 0.7)
    soot = np.clip(shade, 0.0, 0.5)
    # One layer of both, brought to the canvas's resolution.
    alpha = dust + soot - dust * soot
    share = (dust / (dust + soot + 1e-6))[..., None]
    colour = _DARK + (_DUST - _DARK) * share
    soft = np.concatenate([colour, 255.0 * alpha[..., None]], axis=-1)
    cv2.resize(
        np.round(soft).astype(np.uint8),
        canvas.picture.shape[1::-1],
        dst=canvas.picture,
        interpolation=cv2.INTER_LINEAR,
    )


def paint_ragged_edges(
    canvas: RoadCanvas, site: Site, openings: Sequence[Mouth], rng: np.random.Generator
) -> None:
    """Earth and plants that creep onto asphalt where a verge lies beside it."""
    strips = site.section.strips
    for one, two in pairwise(strips):
        if (one.surface == Surface.VERGE) == (two.surface == Surface.VERGE):
            continue
        verge, side = (one, 1.0) if one.surface == Surface.VERGE else (two, -1.0)
        if verge.material not in _EDGES or abs(one.height - two.height) > 0.02:
            continue
        _, row = canvas.pixels(canvas.start, one.left)
        first = round(float(row)) - (0 if side < 0 else round(_CREEP * canvas.scale))
        depth = np.arange(round(_CREEP * canvas.scale)) + 0.5
        depth = (depth if side < 0 else depth[::-1]) / canvas.scale
        noise = np.roll(_creep_tile(), offset(rng), axis=(0, 1))
        reach = rng.uniform(0.02, 0.09) + 0.06 * noise[: len(depth)]
        mask = np.clip((reach - depth[:, None]) / 0.025, 0.0, 1.0)
        copies = -(-canvas.picture.shape[1] // mask.shape[1])
        whole = np.tile((230.0 * mask).astype(np.uint8), (1, copies))
        for mouth in openings:
            begin, right, end, left = mouth.paved.bounds
            if right - 0.1 < one.left < left + 0.1:
                columns = canvas.pixels([begin, end], 0.0)[:, 0].astype(int)
                whole[:, max(columns[0], 0) : max(columns[1], 0)] = 0
        canvas.lay(whole, 0, first, _EDGES[verge.material], grain=offset(rng))


def paint_stains(canvas: RoadCanvas, site: Site, rng: np.random.Generator) -> None:
    """Oil in parking bays and in the middle of lanes, water marks, chewing gum."""
    length = canvas.end - canvas.start
    places: list[Floats] = []
    for strip in site.section.strips:
        if strip.surface == Surface.PARKING:
            middle = 0.5 * (strip.left + strip.right)
            count = rng.poisson(length / 5.0)
            places.append(_scattered(canvas, rng, count, middle, 0.4, (0.25, 0.9)))
        elif strip.surface == Surface.PAVEMENT:
            middle, half = 0.5 * (strip.left + strip.right), 0.4 * (strip.left - strip.right)
            places.append(
                _scattered(canvas, rng, rng.poisson(length / 2), middle, half, (0.04, 0.12))
            )
    calm = site.style in (Style.RESIDENTIAL, Style.CAMPUS, Style.CITY)
    for lane in site.section.lanes:
        count = rng.poisson(length / (9.0 if calm else 30.0))
        places.append(_scattered(canvas, rng, count, lane.left, 0.35, (0.15, 0.8)))
    blobs = _blobs()
    for along, left, across, strength in np.concatenate(places) if places else ():
        blob = blobs[int(rng.integers(len(blobs)))]
        pixels = max(2, round(across * canvas.scale))
        size = (max(2, int(pixels * rng.uniform(0.8, 1.9))), pixels)
        stamp: Mask = cv2.resize(blob, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
        x, y = canvas.pixels(along, left)
        canvas.lay(stamp, int(x) - stamp.shape[1] // 2, int(y) - pixels // 2, _OIL, strength)


def paint_leaves(
    canvas: RoadCanvas, site: Site, openings: Sequence[Mouth], rng: np.random.Generator
) -> None:
    """Single leaves near kerbs and under trees, and weeds in the joints of kerbs."""
    if site.style == Style.HIGHWAY or len(_kerbs(site.section)) == 0:
        return
    length = canvas.end - canvas.start
    _strew(canvas, site, openings, rng, _LEAVES, int(9.0 * rng.beta(0.7, 1.6) * length), 0.45)
    _strew(canvas, site, openings, rng, _WEEDS, int(14.0 * rng.beta(0.7, 1.6) * length), 0.035)


def _strew(
    canvas: RoadCanvas,
    site: Site,
    openings: Sequence[Mouth],
    rng: np.random.Generator,
    colours: NDArray[np.int64],
    count: int,
    spread: float,
) -> None:
    """So many specks of some colours, mostly within `spread` metres of kerbs."""
    # Heaps here, nothing there.
    heaps = rng.uniform(canvas.start, canvas.end, max(3, count // 150))
    heap = rng.integers(0, len(heaps), count)
    along = heaps[heap] + rng.normal(0.0, 5.0, count)
    away = rng.exponential(spread, count) * rng.choice([-1.0, 1.0], count)
    left = rng.choice(_kerbs(site.section), count) + away
    for mouth in openings:
        first, right, last, far = mouth.paved.bounds
        away_from = (along < first) | (along > last) | (left < right) | (left > far)
        along, left = along[away_from], left[away_from]
    count = len(along)
    x, y = canvas.pixels(along, left).astype(int).T
    colour = colours[rng.integers(0, len(colours), count)] * rng.uniform(0.6, 1.1, (count, 1))
    pixel = np.concatenate([colour, np.full((count, 1), 235.0)], axis=1).astype(np.uint8)
    size = max(1, round(0.05 * canvas.scale))
    height, width = canvas.picture.shape[:2]
    lying = rng.random(count) < 0.5
    for dx in range(size):
        for dy in range(size):
            # Leaves of various shapes: some corners stay free.
            kept = (dx + dy == 0) | (rng.random(count) < 0.6) | (lying & (dy == 0))
            column, row = x + dx, y + dy
            inside = kept & (column >= 0) & (column < width) & (row >= 0) & (row < height)
            canvas.picture[row[inside], column[inside]] = pixel[inside]


def _scattered(
    canvas: RoadCanvas,
    rng: np.random.Generator,
    count: int,
    middle: float,
    spread: float,
    sizes: tuple[float, float],
) -> Floats:
    """Rows of along, left, size, strength."""
    return np.stack(
        [
            rng.uniform(canvas.start, canvas.end, count),
            middle + spread * rng.uniform(-1.0, 1.0, count),
            rng.uniform(*sizes, count),
            rng.uniform(0.15, 0.55, count),
        ],
        axis=-1,
    )


def _kerbs(section: CrossSection) -> Floats:
    """Where something ends: kerbs, verges, walls of gardens."""
    strips = section.strips
    return np.array(
        [
            one.left
            for one, two in pairwise(strips)
            if Surface.KERB in (one.surface, two.surface)
            or (one.surface == Surface.VERGE) != (two.surface == Surface.VERGE)
        ]
    )


def _edge_distance(section: CrossSection, left: Floats) -> Floats:
    """To the nearest edge where dirt gathers, metres."""
    edges = np.array([*_kerbs(section), *section.edges])
    return np.asarray(np.abs(left[:, None] - edges).min(axis=1))


def _closed(openings: Sequence[Mouth], along: Floats, left: Floats) -> NDArray[np.float64]:
    """1, but 0 before the mouths of side streets, shape (left, along)."""
    closed = np.ones((len(left), len(along)))
    for mouth in openings:
        first, right, last, far = mouth.paved.bounds
        beyond = left > right - 0.5 if mouth.street.side > 0 else left < far + 0.5
        closed[np.ix_(beyond, (along > first) & (along < last))] = 0.0
    return closed


def _blotches(height: int, width: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """Noise of some decimetres."""
    down, along = (int(shift) for shift in rng.integers(0, _BLOTCHES, 2))
    rows = (np.arange(height) + down) % _BLOTCHES
    return _blotch_tile()[rows][:, (np.arange(width) + along) % _BLOTCHES]


@functools.cache
def _blotch_tile() -> NDArray[np.float32]:
    rng = np.random.default_rng(76)
    return fractal_noise(rng, _BLOTCHES, _BLOTCHES, cells=128, octaves=3, persistence=0.9)


@functools.cache
def _creep_tile() -> NDArray[np.float32]:
    rng = np.random.default_rng(74)
    return fractal_noise(rng, 512, 512, cells=9, octaves=7, persistence=0.8)


@functools.cache
def _blobs() -> tuple[Mask, ...]:
    """Irregular soft spots."""
    rng = np.random.default_rng(73)
    side = 64
    radius = np.hypot(*np.meshgrid(*2 * [np.linspace(-1.0, 1.0, side)]))
    masks = []
    for _ in range(10):
        noise = fractal_noise(rng, side, side, cells=3, octaves=4, persistence=0.6)
        spot = np.clip(1.3 * (0.62 + 0.16 * noise - radius), 0.0, 1.0) ** 0.7
        masks.append((255.0 * spot).astype(np.uint8))
    return tuple(masks)
