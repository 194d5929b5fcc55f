"""Residential houses that stand alone: one or two storeys under a steep tiled roof."""

from __future__ import annotations

from dataclasses import dataclass, replace

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


@dataclass(frozen=True)
class _House:
    """What the parts of one house have in common."""

    width: float
    depth: float
    plinth: float
    eaves: float
    sills: Floats
    """Sills of each storey's windows."""
    paint: Material
    bands: list[Band]
    style: WindowStyle
    roof: RoofMaterials


def detached(width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """A house with its eaves or its gable to the street, or under a hipped roof."""
    storeys = int(rng.choice([1, 2], p=[0.35, 0.65]))
    plinth = float(rng.uniform(0.3, 0.9))
    eaves = plinth + storeys * _STOREY + float(rng.uniform(0.0, 0.5))
    paint = palette.brick(rng) if rng.random() < 0.1 else palette.stucco(rng)
    house = _House(
        width=width,
        depth=depth,
        plinth=plinth,
        eaves=eaves,
        sills=plinth + 0.95 + _STOREY * np.arange(storeys),
        paint=paint,
        bands=_bands(paint, plinth, eaves, rng),
        style=_style(paint, rng),
        roof=palette.tiled_roof(rng),
    )
    sides = [_front(house, rng), *(_other(house, length, rng) for length in (depth, width, depth))]
    pitch = float(rng.uniform(0.65, 0.95 if storeys == 1 else 0.8))
    form = str(rng.choice(["eaves", "gable", "hip"], p=[0.5, 0.32, 0.18]))
    if form == "hip":
        roof = _hip(house, pitch, rng)
    elif form == "eaves":
        sides[1] += _gable(house, depth, pitch, rng)
        sides[3] += _gable(house, depth, pitch, rng)
        roof = _ridge(house, width, depth, pitch, rng)
    else:
        sides[0] += _gable(house, width, pitch, rng)
        sides[2] += _gable(house, width, pitch, rng)
        # The left end of its roof looks at the street.
        roof = _ridge(house, depth, width, pitch, rng)
        roof = roof.placed(0.5 * width, 0.5 * depth, yaw=0.5 * np.pi)
    return merge([enclose(width, depth, sides), roof])


def _bands(paint: Material, plinth: float, eaves: float, rng: np.random.Generator) -> list[Band]:
    """Plinth, a strip that rain has splashed, and the wall above."""
    base = palette.darker(paint, 0.35) if rng.random() < 0.6 else Material("concrete/1", (0.4,) * 3)
    bands = [Band(BELOW_GROUND, plinth, base, 0.03)]
    if paint.texture.startswith("stucco"):
        bands.append(Band(plinth, plinth + 1.0, palette.splashed(paint)))
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


def _front(house: _House, rng: np.random.Generator) -> list[Panels]:
    """Towards the street: the entrance in one column, sometimes a balcony beside it."""
    columns = evenly(house.width, 3.0, 5)
    entrance = int(rng.integers(len(columns)))
    beside = (entrance + 1) % len(columns)
    # Folding shutters need as much room again.
    wide = min(float(rng.uniform(1.1, 1.6)), 0.42 * house.width / len(columns))
    high = float(rng.uniform(1.15, 1.4))
    ground = grid(np.delete(columns, entrance), house.sills[:1], wide, high)
    upper = grid(columns, house.sills[1:], wide, high)
    x = float(columns[entrance])
    door = np.array([[x - 0.55, x + 0.55, house.plinth, house.plinth + 2.15]])
    parts = steps(x, 1.7, house.plinth, palette.CONCRETE)
    if len(upper) and rng.random() < 0.35:
        # One window of the upper floor becomes a glass door.
        upper[beside] += (-0.3, 0.3, -0.9, 0.0)
        parts += _balcony(house, float(columns[beside]), rng)
    openings = np.concatenate([ground, upper])
    trim = house.style.surround or palette.WHITE
    parts += wall(house.width, house.bands, np.concatenate([openings, door]))
    parts += windows(openings, house.style, rng)
    parts += doors(door, palette.door_leaf(rng), trim, trim)
    if len(upper) and rng.random() < 0.6:
        parts.append(canopy(x, 1.7, 0.9, house.plinth + 2.3, house.roof.board))
    edge = 0.5 * house.width - 0.2
    ends = (-edge, edge)[: int(rng.integers(1, 3))]
    parts.append(downpipes(ends, house.eaves, house.roof.gutter))
    return parts


def _balcony(house: _House, x: float, rng: np.random.Generator) -> list[Panels]:
    rail = palette.pick(rng, palette.IRON, palette.WHITE_FRAME, Material("timber/1"))
    bars = not rail.texture.startswith("timber")
    width = min(3.0, house.width - 2.0 * abs(x))
    place = (x, house.sills[1] - 0.95)
    return balconies(place, width, 1.3, palette.CONCRETE, rail, bars=bars)


def _other(house: _House, length: float, rng: np.random.Generator) -> list[Panels]:
    """A side or the rear: fewer windows, in places that the rooms behind them ask for."""
    openings = grid(evenly(length, 3.4, 3), house.sills, 1.15, 1.2)
    openings = openings[rng.random(len(openings)) < 0.88]
    parts = wall(length, house.bands, openings)
    return parts + windows(openings, house.style.plain(), rng)


def _gable(house: _House, span: float, pitch: float, rng: np.random.Generator) -> list[Panels]:
    """The upper end of a wall, with a window of the attic if there is room."""
    rise = 0.5 * span * pitch
    if rise < 2.6:
        return gable(span, house.eaves, rise, house.paint)
    opening = grid([0.0], [house.eaves + 0.35], float(rng.uniform(0.9, 1.4)), 1.2)
    style = replace(house.style, folding=None, sashes=1)
    parts = gable(span, house.eaves, rise, house.paint, opening)
    return parts + windows(opening, style, rng)


def _hip(house: _House, pitch: float, rng: np.random.Generator) -> Mesh:
    overhang = float(rng.uniform(0.35, 0.6))
    rise = 0.5 * min(house.width, house.depth) * pitch
    parts = hip_roof(house.width, house.depth, house.eaves, rise, overhang, house.roof)
    parts.append(_gutters(house, house.width + 2 * overhang, house.depth, overhang, pitch))
    return solid(parts + _chimney(0.0, 0.5 * house.depth, house.eaves + rise, rng))


def _ridge(
    house: _House, length: float, span: float, pitch: float, rng: np.random.Generator
) -> Mesh:
    """A gabled roof whose ridge runs along x, with all that stands on it."""
    overhang = float(rng.uniform(0.35, 0.6))
    rise, reach = 0.5 * span * pitch, 0.5 * length + 0.3
    profile = gable_profile(span, house.eaves, rise, overhang)
    parts = swept_roof(profile, -reach, reach, house.roof)
    parts.append(_gutters(house, 2 * reach, span, overhang, pitch))
    parts += _roof_windows(house, length, span, pitch, rng)
    x = float(0.3 * length * rng.choice([-1, 1]))
    return solid(parts + _chimney(x, 0.5 * span + 0.6, house.eaves + rise - 0.4, rng))


def _gutters(house: _House, length: float, span: float, overhang: float, pitch: float) -> Panels:
    edge = house.eaves + THICKNESS - overhang * pitch
    half = 0.5 * length
    return gutters(house.roof.gutter, -half, half, -overhang, span + overhang, edge)


def _roof_windows(
    house: _House, length: float, span: float, pitch: float, rng: np.random.Generator
) -> list[Panels]:
    """Dormers in a roof that is high enough, or skylights, or nothing."""
    slope = Slope(house.eaves + THICKNESS, pitch)
    columns = evenly(length, 4.0, 3)
    kind = rng.random()
    if kind < 0.45 and 0.5 * span * pitch > 3.2:
        return dormers(
            columns[: max(1, len(columns) - int(rng.integers(2)))],
            0.7,
            slope,
            (1.6, 1.25),
            house.paint,
            house.style.frame,
            house.roof,
            int(rng.integers(7)),
            gabled=bool(rng.random() < 0.6),
        )
    if kind < 0.8:
        return skylights(columns[: int(rng.integers(1, 3))], 0.3 * span, slope, palette.DARK_FRAME)
    return []


def _chimney(x: float, y: float, ridge: float, rng: np.random.Generator) -> list[Panels]:
    body = palette.pick(rng, Material("brick/0"), Material("brick/3"), palette.WHITE)
    parts = chimney(x, y, ridge - 1.5, ridge + 1.1, body, palette.CONCRETE)
    if rng.random() < 0.25:
        parts += satellite_dish(x + 0.6, y - 0.4, ridge + 0.9)
    return parts
