"""Houses for things: rows of garages, and industrial halls."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.buildings import palette
from avsec_gym.world.models.buildings.attachments import canopy, downpipes, sign
from avsec_gym.world.models.buildings.facade import (
    BELOW_GROUND,
    Band,
    enclose,
    evenly,
    gable,
    grid,
    wall,
)
from avsec_gym.world.models.buildings.panels import boxes, solid, upright
from avsec_gym.world.models.buildings.roofs import (
    RoofMaterials,
    flat_roof,
    gable_profile,
    gutters,
    swept_roof,
)
from avsec_gym.world.models.buildings.shop_front import SHOPS, SIGNS
from avsec_gym.world.models.buildings.windows import bars, doors, pane_material, reveals

_GARAGE_DOORS = 4
_DOOR_TINTS = ((0.8, 0.8, 0.78), (0.55, 0.56, 0.56), (0.75, 0.68, 0.52), (0.3, 0.36, 0.3))


def garage(width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """A row of garages with up-and-over doors under one flat roof."""
    count = max(1, round(width / 3.0))
    pitch, height = width / count, float(rng.uniform(2.4, 2.75))
    red, green, blue = palette.linear(palette.STUCCO[int(rng.choice([0, 1, 1, 6, 7]))])
    paint = Material(f"stucco/{int(rng.integers(4))}", (red, green, blue))
    bands = [
        Band(BELOW_GROUND, 0.0, paint),
        Band(0.0, 1.0, palette.splashed(paint)),
        Band(1.0, height, paint),
    ]
    openings = grid(evenly(width, pitch, count), [0.03], min(2.45, pitch - 0.4), 2.05)
    front = wall(width, bands, openings)
    like = rng.random() < 0.5
    first = _garage_door(rng)
    for opening in openings:
        leaf = first if like or rng.random() < 0.5 else _garage_door(rng)
        front += doors(opening[None], leaf, paint, paint, recess=0.18, border=0.0)
    side, rear = wall(depth, bands), wall(width, bands)
    rim = palette.pick(rng, palette.ZINC, palette.WHITE, palette.CONCRETE, palette.BROWN_FRAME)
    roof = flat_roof(width, depth, height, rim, palette.GRAVEL, 0.06)
    return merge([enclose(width, depth, [front, side, rear, side]), solid(roof)])


def hall(width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """A hall clad in metal: gates, a strip of windows below the eaves, an office door."""
    height, base = float(rng.uniform(5.5, 8.5)), float(rng.uniform(0.4, 1.2))
    tints = ((0.6, 0.61, 0.62), (0.68, 0.66, 0.6), (0.25, 0.35, 0.5), (0.3, 0.32, 0.33))
    clad = Material("cladding", tints[int(rng.integers(len(tints)))], mirror=0.03, infrared=0.5)
    bands = [Band(BELOW_GROUND, base, Material("concrete/2"), 0.03), Band(base, height, clad)]
    # The front: gates, an office door, a strip of windows.
    gates = max(1, round(width / 9.0))
    columns = evenly(width, width / gates, gates)
    opening = grid(columns, [0.03], 3.6, 4.0)
    door = np.array([[columns[0] + 2.6, columns[0] + 3.6, 0.03, 2.1]])
    strip = np.array([[-0.45 * width, 0.45 * width, height - 1.25, height - 0.35]])
    front = wall(width, bands, np.concatenate([opening, door, strip]))
    gate = Material("cladding", tints[int(rng.integers(len(tints)))], infrared=0.5)
    front += [
        reveals(opening, -0.06, 0.3, palette.ALUMINIUM),
        upright(gate, *opening.T, y=0.3),
        *doors(
            door, Material("door/4"), palette.ALUMINIUM, palette.ALUMINIUM, recess=0.1, border=0.06
        ),
        reveals(strip, 0.0, 0.1, palette.ALUMINIUM),
        upright(pane_material(6), *strip.T, y=0.1),
        bars(palette.ALUMINIUM, strip[0], round(0.9 * width / 1.6), 1, 0.07, 0.06),
        canopy(float(columns[0]), 4.6, 1.3, 4.3, palette.ZINC),
        downpipes([0.5 * width - 0.25, 0.25 - 0.5 * width], height, palette.ZINC),
    ]
    if rng.random() < 0.7:
        x = float(rng.uniform(-0.2, 0.2)) * width
        front += sign(x - 2.2, x + 2.2, height - 2.4, height - 1.5, int(rng.integers(SHOPS, SIGNS)))
    # The other walls, under a flat roof or a gabled one with a skylight.
    high = np.array([[-0.42 * depth, 0.42 * depth, height - 1.25, height - 0.35]])
    side, rear = wall(depth, bands, high), wall(width, bands)
    side += [
        reveals(high, 0.0, 0.1, palette.ALUMINIUM),
        upright(pane_material(5), *high.T, y=0.1),
        bars(palette.ALUMINIUM, high[0], round(0.84 * depth / 1.8), 1, 0.07, 0.06),
    ]
    if rng.random() < 0.5:
        roof = flat_roof(width, depth, height, palette.ZINC, palette.GRAVEL, 0.08)
        return merge([enclose(width, depth, [front, side, rear, side]), solid(roof)])
    rise = 0.09 * depth
    ends = [side + gable(depth, height, rise, clad) for _ in range(2)]
    metal = RoofMaterials(Material("cladding", (0.4, 0.4, 0.4)), palette.ZINC, palette.ZINC)
    reach = 0.5 * width + 0.15
    profile = gable_profile(depth, height, rise, 0.3)
    roof = swept_roof(profile, -reach, reach, metal)
    roof.append(gutters(palette.ZINC, -reach, reach, -0.3, depth + 0.3, float(profile[0, 1])))
    light = boxes(
        Material("plain", (0.5, 0.52, 0.54), mirror=0.05),
        (-0.35 * width, 0.45 * depth, height + 0.7 * rise),
        (0.35 * width, 0.55 * depth, height + rise + 0.6),
    )
    return merge([enclose(width, depth, [front, ends[0], rear, ends[1]]), solid([*roof, light])])


def _garage_door(rng: np.random.Generator) -> Material:
    tint = _DOOR_TINTS[int(rng.choice(len(_DOOR_TINTS), p=[0.5, 0.25, 0.15, 0.1]))]
    return Material(f"garage_door/{int(rng.integers(_GARAGE_DOORS))}", tint, infrared=0.5)
