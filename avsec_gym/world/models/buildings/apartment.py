"""Blocks of flats of the 1960s to 1980s: balconies, staircases behind glass, flat roofs."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.buildings import palette
from avsec_gym.world.models.buildings.attachments import balconies, canopy, downpipes, steps
from avsec_gym.world.models.buildings.facade import BELOW_GROUND, Band, enclose, evenly, grid, wall
from avsec_gym.world.models.buildings.panels import Floats, Panels, boxes, solid, upright
from avsec_gym.world.models.buildings.roofs import flat_roof, gutters, hip_roof
from avsec_gym.world.models.buildings.windows import WindowStyle, bars, doors, reveals, windows

_STOREY = 2.8


def apartment(width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """Three to five storeys of like flats on both sides of a staircase."""
    storeys = int(rng.integers(3, 6)) if width > 14 else int(rng.integers(3, 5))
    plinth = float(rng.uniform(0.3, 1.0))
    eaves = plinth + storeys * _STOREY + 0.2
    paint = palette.stucco(rng)
    base = Material("concrete/1", (0.5, 0.5, 0.5))
    bands = [
        Band(BELOW_GROUND, plinth, base, 0.03),
        Band(plinth, plinth + 1.0, palette.splashed(paint)),
        Band(plinth + 1.0, eaves, paint),
    ]
    style = WindowStyle(
        frame=palette.pick(rng, palette.WHITE_FRAME, palette.WHITE_FRAME, palette.BROWN_FRAME),
        reveal=paint,
        sill=palette.STONE_SILL,
        shutter=palette.roller_shutter(rng),
    )
    sills = plinth + 0.9 + _STOREY * np.arange(storeys)
    sides = [
        _front(width, plinth, sills, bands, style, rng),
        _plain(depth, sills, bands, style, rng, 1),
        _plain(width, sills, bands, style, rng, 12 // storeys),
        _plain(depth, sills, bands, style, rng, 1),
    ]
    if rng.random() < 0.6:
        rim = palette.pick(rng, palette.CONCRETE, palette.ZINC, palette.BROWN_FRAME)
        roof = flat_roof(width, depth, eaves, rim, palette.GRAVEL, 0.25)
        shaft = boxes(paint, (-1.6, 0.4 * depth, eaves), (1.6, 0.7 * depth, eaves + 1.6))
        roof.append(shaft)
    else:
        tiles = palette.tiled_roof(rng)
        overhang, rise = 0.5, 0.22 * min(width, depth)
        roof = hip_roof(width, depth, eaves, rise, overhang, tiles)
        reach = 0.5 * width + overhang
        roof.append(gutters(tiles.gutter, -reach, reach, -overhang, depth + overhang, eaves))
    return merge([enclose(width, depth, sides), solid(roof)])


def _front(
    width: float,
    plinth: float,
    sills: Floats,
    bands: list[Band],
    style: WindowStyle,
    rng: np.random.Generator,
) -> list[Panels]:
    half, eaves = 0.5 * width, bands[-1].high
    stair = 1.2
    inner = evenly(half - stair, 3.4, 3 if len(sills) < 5 else 2) + 0.5 * (half + stair)
    columns = np.concatenate([-inner[::-1], inner])
    openings = grid(columns, sills, 1.6, 1.35)
    # The column nearest to each end of the wall, or to the stairs, has the balconies.
    own = 0 if rng.random() < 0.5 else len(inner) - 1
    places = np.array([columns[own], -columns[own]])
    with_balcony = np.isclose(np.abs(openings[:, :2].mean(axis=1)), abs(places[0]))
    openings[with_balcony] += (-0.3, 0.3, -0.85, 0.0)
    door = np.array([[-0.6, 0.6, plinth, plinth + 2.2]])
    light = np.array([[-0.7, 0.7, sills[1] - 0.1, eaves - 0.8]])
    parts = wall(width, bands, np.concatenate([openings, door, light]))
    parts += windows(openings, style, rng)
    parts += doors(door, palette.door_leaf(rng), palette.ALUMINIUM, style.reveal)
    glass = Material("glass_blocks", mirror=0.05, infrared=0.2)
    parts += [
        reveals(light, 0.0, 0.12, style.reveal),
        upright(glass, *light[0], y=0.12),
        bars(style.frame, light[0], 2, 2 * (len(sills) - 1), 0.07, 0.08),
        canopy(0.0, 2.6, 1.2, plinth + 2.4, palette.CONCRETE),
        *steps(0.0, 2.0, plinth, palette.CONCRETE),
    ]
    parapet = palette.pick(
        rng,
        palette.WHITE,
        palette.CONCRETE,
        Material("cladding", palette.linear((150, 60, 40))),
        Material("cladding", palette.linear((60, 90, 130))),
        Material("cladding", palette.linear((190, 170, 90))),
        Material("timber/1"),
    )
    width_each = min(3.6, 2.0 * (half - abs(places[0])) + 0.4, 0.5 * half)
    spots = [(x, sill - 0.9) for x in places for sill in sills[1:]]
    parts += balconies(spots, max(width_each, 2.2), 1.3, palette.CONCRETE, parapet)
    parts.append(downpipes([half - 0.2, 0.2 - half], eaves, palette.ZINC))
    return parts


def _plain(
    length: float,
    sills: Floats,
    bands: list[Band],
    style: WindowStyle,
    rng: np.random.Generator,
    columns: int,
) -> list[Panels]:
    openings = grid(evenly(length, length / columns), sills, 1.2, 1.3)
    if rng.random() < 0.1:
        openings = openings[:0]
    return wall(length, bands, openings) + windows(openings, style.plain(), rng)
