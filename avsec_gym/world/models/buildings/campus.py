"""University buildings: concrete bands with strips of windows, or blue tiles beside glass."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.buildings import palette
from avsec_gym.world.models.buildings.attachments import canopy, steps
from avsec_gym.world.models.buildings.facade import BELOW_GROUND, Band, enclose, grid, wall
from avsec_gym.world.models.buildings.panels import Floats, Panels, boxes, solid, upright
from avsec_gym.world.models.buildings.roofs import flat_roof
from avsec_gym.world.models.buildings.windows import PANES, bars, doors, pane_material, reveals

_GLAZES = (
    (0.42, 0.58, 0.72),
    (1.0, 1.0, 0.98),
    (0.95, 0.78, 0.52),
    (0.62, 0.32, 0.22),
    (0.50, 0.62, 0.52),
    None,
)
"""Glazes of tiles: blue, white, ochre, rust, green; None for black ones."""


def campus(width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """A long house with a flat roof."""
    if rng.random() < 0.4:
        return _pavilion(width, depth, rng)
    return _storeys(width, depth, rng)


def _storeys(width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """Parapets and window strips by turns, columns before them."""
    storey, storeys = 3.6, int(rng.integers(2, 5))
    height = storeys * storey + 0.6
    skin = palette.pick(
        rng, Material("concrete/0"), Material("concrete/2"), palette.brick(rng), palette.WHITE
    )
    bands = [Band(BELOW_GROUND, 0.5, palette.CONCRETE, 0.02), Band(0.5, height, skin)]
    sills = 1.4 + storey * np.arange(storeys)
    frame = palette.pick(rng, palette.ALUMINIUM, palette.WHITE_FRAME, palette.DARK_FRAME)
    front = _strips(width, sills, bands, frame, rng)
    x = float(rng.uniform(-0.25, 0.25)) * width
    front += _entrance(x, frame)
    if rng.random() < 0.5:
        at = np.linspace(-0.5 * width, 0.5 * width, 2 + round(width / 6.0))
        low = np.stack([at - 0.2, np.full_like(at, -0.35), np.full_like(at, BELOW_GROUND)], axis=1)
        high = np.stack([at + 0.2, np.zeros_like(at), np.full_like(at, height)], axis=1)
        away = np.abs(at - x) > 2.2
        front.append(boxes(palette.CONCRETE, low[away], high[away], without=("back",)))
    rear = _strips(width, sills, bands, frame, rng)
    side = _strips(depth, sills, bands, frame, rng) if rng.random() < 0.7 else wall(depth, bands)
    roof = flat_roof(width, depth, height, palette.CONCRETE, palette.GRAVEL, 0.15)
    plant = boxes(
        Material("cladding", (0.5, 0.52, 0.54)),
        (-0.2 * width, 0.35 * depth, height),
        (0.1 * width, 0.75 * depth, height + 2.0),
    )
    return merge([enclose(width, depth, [front, side, rear, side]), solid([*roof, plant])])


def _strips(
    width: float, sills: Floats, bands: list[Band], frame: Material, rng: np.random.Generator
) -> list[Panels]:
    """Windows from end to end of every storey; each pane its own room."""
    openings = grid([0.0], sills, width - 1.2, 1.7)
    parts = wall(width, bands, openings)
    parts.append(reveals(openings, 0.0, 0.18, frame))
    count = round(width / 1.9)
    edges = np.linspace(openings[0, 0], openings[0, 1], count + 1)
    for opening in openings:
        rooms = rng.choice((3, 4, 6, 7), count)
        for variant in np.unique(rooms):
            here = np.flatnonzero(rooms == variant)
            parts.append(
                upright(
                    pane_material(int(variant)),
                    edges[here],
                    edges[here + 1],
                    opening[2],
                    opening[3],
                    y=0.18,
                    once=True,
                )
            )
        parts.append(bars(frame, opening, count, 1, 0.09, 0.12))
    blinds = Material("shutter", (0.6, 0.6, 0.58), infrared=0.5)
    down = [
        (edges[i] + 0.06, edges[i + 1] - 0.06, opening[3] - drop, opening[3])
        for opening in openings
        for i, drop in enumerate(np.where(rng.random(count) < 0.3, rng.uniform(0.3, 1.6, count), 0))
        if drop
    ]
    if down:
        parts.append(upright(blinds, *np.array(down).T, y=0.15))
    return parts


def _entrance(x: float, frame: Material) -> list[Panels]:
    """Glass doors in a porch that stands before the wall."""
    porch = np.array([[x - 1.5, x + 1.5, 0.2, 2.7]])
    leaf = Material("door/5", mirror=0.06, infrared=0.1)
    box = boxes(frame, (x - 1.6, -0.3, -0.3), (x + 1.6, 0.0, 2.9), without=("back", "bottom"))
    half = np.array([[x - 1.5, x, 0.2, 2.7], [x, x + 1.5, 0.2, 2.7]])
    faces = upright(leaf, *half.T, y=-0.32, once=True)
    return [
        box,
        faces,
        bars(frame, porch[0], 2, 1, 0.08, -0.34),
        canopy(x, 4.0, 1.4, 2.95, palette.CONCRETE),
        *steps(x, 3.4, 0.2, palette.CONCRETE),
    ]


def _pavilion(width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """One high storey: a wall of coloured tiles, and a hall of glass with white bars."""
    height = float(rng.uniform(4.2, 6.0))
    share = float(rng.uniform(0.35, 0.6))
    glaze = _GLAZES[int(rng.integers(len(_GLAZES)))]
    tiles = Material(f"wall_tile/{int(glaze is None)}", glaze or (1.0, 1.0, 1.0), mirror=0.03)
    bands = [Band(BELOW_GROUND, 0.35, palette.CONCRETE, -0.05), Band(0.35, height, tiles)]
    left, right = (share - 0.5) * width, 0.5 * width - 0.3
    flip = rng.random() < 0.5
    glass = np.array([[-right, -left] if flip else [left, right]])
    glass = np.c_[glass, 0.35, height - 0.35]
    parts = wall(width, bands, glass)
    parts.append(reveals(glass, -0.02, 0.3, palette.WHITE_FRAME))
    columns = max(2, round((glass[0, 1] - glass[0, 0]) / 1.7))
    edges = np.linspace(glass[0, 0], glass[0, 1], columns + 1)
    top = height - 1.3
    for number in range(columns):
        room = Material(f"shop_window/{int(rng.integers(3, 5))}", mirror=0.08, infrared=0.05)
        parts.append(upright(room, edges[number], edges[number + 1], 0.35, top, y=0.3, once=True))
    sky = Material("plain", (0.03, 0.035, 0.04), mirror=0.09, infrared=0.05)
    parts += [
        upright(sky, edges[:-1], edges[1:], top, height - 0.35, y=0.3),
        bars(palette.WHITE_FRAME, glass[0], columns, 1, 0.1, 0.22),
        upright(palette.WHITE_FRAME, glass[0, 0], glass[0, 1], top - 0.05, top + 0.05, y=0.23),
    ]
    wide = grid(np.linspace(-0.3, 0.3, 3) * width, [1.2], 2.4, 1.6)
    rear = wall(width, bands, wide)
    for window in wide:
        rear += [
            reveals(window[None], 0.0, 0.15, palette.WHITE_FRAME),
            upright(pane_material(int(rng.integers(PANES))), *window, y=0.15, once=True),
        ]
    side_door = np.array([[-0.5, 0.5, 0.03, 2.1]])
    side = wall(depth, bands, side_door)
    leaf = Material("door/4", infrared=0.4)
    side += doors(side_door, leaf, palette.ALUMINIUM, palette.ALUMINIUM, recess=0.1, border=0.06)
    rim = palette.pick(rng, palette.WHITE, palette.WHITE, palette.ZINC)
    roof = flat_roof(width, depth, height, rim, palette.GRAVEL, 0.3)
    return merge([enclose(width, depth, [parts, side, rear, side]), solid(roof)])
