"""Residential houses that stand alone: one or two storeys under a steep tiled roof."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.buildings import palette
from avsec_gym.world.models.buildings.attachments import (
    balconies,
    canopy,
    downpipes,
    satellite_dish,
    steps,
)
from avsec_gym.world.models.buildings.dormers import Slope, dormers, skylights
from avsec_gym.world.models.buildings.facade import (
    BELOW_GROUND,
    Band,
    enclose,
    evenly,
    gable,
    grid,
    wall,
)
from avsec_gym.world.models.buildings.panels import Floats, Panels, solid
from avsec_gym.world.models.buildings.roofs import (
    THICKNESS,
    RoofMaterials,
    chimney,
    gable_profile,
    gutters,
    hip_roof,
    swept_roof,
)
from avsec_gym.world.models.buildings.windows import WindowStyle, doors, windows

_STOREY = 2.75


def detached(width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """A house with its eaves or its gable to the street, or under a hipped roof."""
    storeys = int(rng.choice([1, 2], p=[0.35, 0.65]))
    plinth = float(rng.uniform(0.3, 0.9))
    eaves = plinth + storeys * _STOREY + float(rng.uniform(0.0, 0.5))
    form = str(rng.choice(["eaves", "gable", "hip"], p=[0.5, 0.32, 0.18]))
    materials = palette.tiled_roof(rng)
    paint = palette.brick(rng) if rng.random() < 0.1 else palette.stucco(rng)
    bands = _bands(paint, plinth, eaves, rng)
    style = _style(paint, rng)
    sills = plinth + 0.95 + _STOREY * np.arange(storeys)
    front = _front(width, plinth, sills, bands, style, materials, rng)
    sides = [front, *(_other(length, sills, bands, style, rng) for length in (depth, width, depth))]
    pitch = float(rng.uniform(0.65, 0.95 if storeys == 1 else 0.8))
    span = {"eaves": depth, "gable": width, "hip": min(width, depth)}[form]
    rise = 0.5 * span * pitch
    ends = {"eaves": (1, 3), "gable": (0, 2), "hip": ()}[form]
    for end in ends:
        sides[end] += _gable(span, eaves, rise, paint, style, rng)
    if form == "hip":
        roof = _hip(width, depth, eaves, rise, materials, rng)
    elif form == "eaves":
        roof = _ridge(width, depth, eaves, rise, paint, style, materials, rng)
    else:
        roof = _ridge(depth, width, eaves, rise, paint, style, materials, rng)
        # Its left end looks at the street.
        roof = roof.placed(0.5 * width, 0.5 * depth, yaw=0.5 * np.pi)
    return merge([enclose(width, depth, sides), roof])


def _bands(paint: Material, plinth: float, eaves: float, rng: np.random.Generator) -> list[Band]:
    """Plinth, a strip that rain has splashed, and the wall above."""
    base = palette.darker(paint, 0.35) if rng.random() < 0.6 else Material("concrete/1", (0.4,) * 3)
    bands = [Band(BELOW_GROUND, plinth, base, 0.03)]
    if paint.texture.startswith("stucco"):
        bands.append(Band(plinth, plinth + 1.0, replace(paint, texture="stucco_foot")))
    return [*bands, Band(bands[-1].high, eaves, paint)]


def _style(paint: Material, rng: np.random.Generator) -> WindowStyle:
    frame = palette.pick(
        rng, palette.WHITE_FRAME, palette.WHITE_FRAME, palette.WHITE_FRAME, palette.BROWN_FRAME
    )
    dark = palette.darker(paint, 0.4)
    surround = palette.pick(rng, dark, palette.WHITE) if rng.random() < 0.35 else None
    folding = surround is None and rng.random() < 0.25
    return WindowStyle(
        frame=frame,
        reveal=paint,
        sill=palette.STONE_SILL if surround is None else None,
        surround=surround,
        shutter=palette.roller_shutter(rng) if not folding and rng.random() < 0.8 else None,
        folding=palette.folding_shutter(rng) if folding else None,
    )


def _front(
    width: float,
    plinth: float,
    sills: Floats,
    bands: list[Band],
    style: WindowStyle,
    materials: RoofMaterials,
    rng: np.random.Generator,
) -> list[Panels]:
    columns = evenly(width, 3.0, 5)
    entrance = int(rng.integers(len(columns)))
    # Folding shutters need as much room again.
    size = (
        min(float(rng.uniform(1.1, 1.6)), 0.42 * width / len(columns)),
        float(rng.uniform(1.15, 1.4)),
    )
    ground = grid(np.delete(columns, entrance), sills[:1], *size)
    upper = grid(columns, sills[1:], *size)
    balcony = len(sills) > 1 and rng.random() < 0.35
    if balcony:
        # One window of the upper floor becomes a glass door.
        upper[(entrance + 1) % len(columns)] += (-0.3, 0.3, -0.9, 0.0)
    x = float(columns[entrance])
    door = np.array([[x - 0.55, x + 0.55, plinth, plinth + 2.15]])
    top = bands[-1].high
    trim = style.surround or palette.WHITE
    parts = wall(width, bands, np.concatenate([ground, upper, door]))
    parts += windows(np.concatenate([ground, upper]), style, rng)
    parts += doors(door, palette.door_leaf(rng), trim, trim)
    if balcony:
        place = (columns[(entrance + 1) % len(columns)], sills[1] - 0.95)
        iron = palette.pick(rng, palette.IRON, palette.WHITE_FRAME, Material("timber/1"))
        bars = not iron.texture.startswith("timber")
        parts += balconies(place, 3.0, 1.3, palette.CONCRETE, iron, bars=bars)
    parts += steps(x, 1.7, plinth, palette.CONCRETE)
    if rng.random() < 0.6 and len(sills) > 1:
        parts.append(canopy(x, 1.7, 0.9, plinth + 2.3, materials.board))
    ends = [-0.5 * width + 0.2] if rng.random() < 0.5 else [0.5 * width - 0.2, -0.5 * width + 0.2]
    parts.append(downpipes(ends, top, materials.gutter))
    return parts


def _other(
    length: float, sills: Floats, bands: list[Band], style: WindowStyle, rng: np.random.Generator
) -> list[Panels]:
    """A side or the rear: fewer windows, in places that the rooms behind them ask for."""
    columns = evenly(length, 4.0, 3)
    openings = grid(columns, sills, 1.15, 1.2)
    openings = openings[rng.random(len(openings)) < 0.75]
    return wall(length, bands, openings) + windows(openings, style.plain(), rng)


def _gable(
    span: float,
    eaves: float,
    rise: float,
    paint: Material,
    style: WindowStyle,
    rng: np.random.Generator,
) -> list[Panels]:
    """The upper end of a wall, with a window of the attic if there is room."""
    opening = grid([0.0], [eaves + 0.35], float(rng.uniform(0.9, 1.4)), 1.2)
    if rise < 2.6:
        return gable(span, eaves, rise, paint)
    return gable(span, eaves, rise, paint, opening) + windows(
        opening, replace(style, folding=None, sashes=1), rng
    )


def _hip(
    width: float,
    depth: float,
    eaves: float,
    rise: float,
    materials: RoofMaterials,
    rng: np.random.Generator,
) -> Mesh:
    overhang = float(rng.uniform(0.35, 0.6))
    parts = hip_roof(width, depth, eaves, rise, overhang, materials)
    reach = 0.5 * width + overhang
    edge = eaves + THICKNESS - overhang * rise / (0.5 * min(width, depth))
    parts.append(gutters(materials.gutter, -reach, reach, -overhang, depth + overhang, edge))
    return solid(parts + _top(0.0, 0.5 * depth, eaves + rise, rng))


def _ridge(
    length: float,
    span: float,
    eaves: float,
    rise: float,
    paint: Material,
    style: WindowStyle,
    materials: RoofMaterials,
    rng: np.random.Generator,
) -> Mesh:
    """A gabled roof whose ridge runs along x, with all that stands on it."""
    overhang = float(rng.uniform(0.35, 0.6))
    slope = Slope(eaves + THICKNESS, rise / (0.5 * span))
    reach = 0.5 * length + 0.3
    parts = swept_roof(gable_profile(span, eaves, rise, overhang), -reach, reach, materials)
    edge = slope.eaves - overhang * slope.rise
    parts.append(gutters(materials.gutter, -reach, reach, -overhang, span + overhang, edge))
    parts += _roof_windows(length, span, slope, paint, style, materials, rng)
    x = float(0.3 * length * rng.choice([-1, 1]))
    return solid(parts + _top(x, 0.5 * span + 0.6, eaves + rise - 0.4, rng))


def _roof_windows(
    length: float,
    span: float,
    slope: Slope,
    paint: Material,
    style: WindowStyle,
    materials: RoofMaterials,
    rng: np.random.Generator,
) -> list[Panels]:
    room = 0.5 * span * slope.rise
    kind = rng.random()
    columns = evenly(length, 4.0, 3)
    if kind < 0.45 and room > 3.2:
        size = (1.6, 1.25)
        front = 0.7
        return dormers(
            columns[: max(1, len(columns) - int(rng.integers(2)))],
            front,
            slope,
            size,
            paint,
            style.frame,
            materials,
            int(rng.integers(7)),
            gabled=bool(rng.random() < 0.6),
        )
    if kind < 0.8:
        return skylights(columns[: int(rng.integers(1, 3))], 0.3 * span, slope, palette.DARK_FRAME)
    return []


def _top(x: float, y: float, ridge: float, rng: np.random.Generator) -> list[Panels]:
    body = palette.pick(rng, Material("brick/0"), Material("brick/3"), palette.WHITE)
    parts = chimney(x, y, ridge - 1.5, ridge + 1.1, body, palette.CONCRETE)
    if rng.random() < 0.25:
        parts += satellite_dish(x + 0.6, y - 0.4, ridge + 0.9)
    return parts
