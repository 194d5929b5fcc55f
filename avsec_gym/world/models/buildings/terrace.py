"""City houses that stand wall to wall: historic fronts, and shops below flats."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.buildings import palette
from avsec_gym.world.models.buildings.attachments import balconies, downpipes, steps
from avsec_gym.world.models.buildings.dormers import Slope, dormers, skylights
from avsec_gym.world.models.buildings.facade import BELOW_GROUND, Band, enclose, evenly, grid, wall
from avsec_gym.world.models.buildings.panels import Floats, Panels, boxes, solid
from avsec_gym.world.models.buildings.roofs import (
    RoofMaterials,
    chimney,
    end_wall,
    gable_profile,
    gutters,
    mansard_profile,
    swept_roof,
)
from avsec_gym.world.models.buildings.shop_front import shop_front
from avsec_gym.world.models.buildings.windows import WindowStyle, doors, windows


@dataclass(frozen=True)
class _House:
    """What the parts of one house have in common."""

    width: float
    depth: float
    storeys: int
    ground: float
    """Height of the ground floor's ceiling, metres."""
    storey: float
    historic: bool
    wall: Material
    trim: Material
    """Cornices and window surrounds."""
    base: Material
    """Base of the ground floor."""
    roof: RoofMaterials
    style: WindowStyle

    @property
    def columns(self) -> Floats:
        """Middles of the windows; high houses have fewer, wider apart."""
        return evenly(self.width, 2.6 if self.historic else 3.0, min(5, 20 // self.storeys))

    @property
    def eaves(self) -> float:
        return self.ground + (self.storeys - 1) * self.storey + 0.35


def terrace(width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """A town house of three to five storeys; blank walls left and right, for its neighbours."""
    house = _draw(width, depth, rng, modern=0.35)
    return _built(house, _ground_floor(house, rng), rng)


def shop(width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """A city block with shop windows under flats or offices."""
    house = _draw(width, depth, rng, modern=0.6)
    return _built(house, shop_front(width, house.ground, house.base, rng), rng)


def _draw(width: float, depth: float, rng: np.random.Generator, modern: float) -> _House:
    historic = bool(rng.random() > modern)
    kind = rng.random()
    if kind < 0.3:
        face = palette.sandstone(rng) if historic else palette.stucco(rng)
    elif kind < 0.5:
        face = palette.brick(rng) if historic else Material(f"concrete/{int(rng.integers(3))}")
    else:
        face = palette.stucco(rng)
    stone = palette.sandstone(rng)
    trim = palette.pick(rng, palette.WHITE, stone, Material("concrete/0"))
    if not historic:
        trim = palette.pick(rng, palette.darker(face, 0.5), palette.WHITE)
    frame = palette.pick(rng, palette.WHITE_FRAME, palette.WHITE_FRAME, palette.BROWN_FRAME)
    style = WindowStyle(
        frame=frame,
        reveal=trim if historic else face,
        recess=0.2 if historic else 0.12,
        transom=0.68 if historic else 0.0,
        surround=trim if historic or rng.random() < 0.3 else None,
        surround_width=0.16 if historic else 0.1,
        lintel=historic and bool(rng.random() < 0.5),
        sill=None if historic else palette.STONE_SILL,
        shutter=palette.roller_shutter(rng) if rng.random() < 0.5 else None,
        shutters_down=0.25,
    )
    return _House(
        width=width,
        depth=depth,
        storeys=int(rng.choice([3, 4, 5], p=[0.4, 0.45, 0.15])),
        ground=float(rng.uniform(3.9, 4.4) if historic else rng.uniform(3.3, 3.8)),
        storey=float(rng.uniform(3.3, 3.7) if historic else rng.uniform(2.75, 3.0)),
        historic=historic,
        wall=face,
        trim=trim,
        base=stone if historic and rng.random() < 0.6 else palette.darker(face, 0.7),
        roof=palette.tiled_roof(rng, slate=0.45 if historic else 0.1),
        style=style,
    )


def _built(house: _House, ground: tuple[list[Panels], Floats], rng: np.random.Generator) -> Mesh:
    """Walls above the given ground floor (and its openings), and the roof."""
    front = _front(house, ground, rng)
    blank = palette.stucco(rng) if rng.random() < 0.6 else Material("brick/0", (0.8, 0.8, 0.8))
    left, right = (_side(house, blank, rng) for _ in range(2))
    profile = _profile(house, rng)
    ends = end_wall(blank, profile, house.eaves, house.depth)
    half = 0.5 * house.width
    roof = [
        *swept_roof(profile, -half, half, house.roof),
        ends[0].at((-half, 0.0, 0.0)),
        ends[1].at((half, 0.0, 0.0)),
        *_on_the_roof(house, profile, rng),
    ]
    body = enclose(house.width, house.depth, [front, right, _rear(house, rng), left])
    return merge([body, solid(roof)])


def _side(house: _House, face: Material, rng: np.random.Generator) -> list[Panels]:
    """A wall that another house may adjoin: blank, or with windows where none was expected."""
    openings: Floats = np.zeros((0, 4))
    if rng.random() < 0.7:
        columns = evenly(house.depth, 3.8, 2 if house.storeys < 4 else 1)
        openings = grid(columns, 1.3 + house.storey * np.arange(house.storeys), 1.1, 1.4)
        openings = openings[openings[:, 3] < house.eaves - 0.3]
        openings = openings[rng.random(len(openings)) < 0.9]
    style = replace(house.style.plain(), reveal=face)
    side = wall(house.depth, [Band(BELOW_GROUND, house.eaves, face)], openings)
    return side + windows(openings, style, rng)


def _front(
    house: _House, ground: tuple[list[Panels], Floats], rng: np.random.Generator
) -> list[Panels]:
    columns = house.columns
    floors = house.ground + house.storey * np.arange(house.storeys - 1)
    size = (1.15, 2.0) if house.historic else (float(rng.uniform(1.2, 1.9)), 1.4)
    upper = grid(columns, floors + 0.9 - 0.15 * house.historic, *size)
    parts, doorway = ground
    middle = int(rng.integers(len(columns)))
    stacked = np.arange(len(upper)) % len(columns) == middle
    choice = str(rng.choice(["balcony", "bay", "none"], p=[0.4, 0.3, 0.3]))
    bay = choice == "bay" and house.historic and 0 < middle < len(columns) - 1
    if choice == "balcony":
        upper[stacked, 2] = floors + 0.12
        parts = parts + _balconies(house, float(columns[middle]), floors, rng)
    elif bay:
        parts = parts + _bay(house, float(columns[middle]), upper[stacked][:-1], rng)
        upper = np.concatenate([upper[~stacked], upper[stacked][-1:]])
    bands = [
        Band(BELOW_GROUND, 0.7, palette.darker(house.base, 0.6), 0.05),
        Band(0.7, house.ground - 0.2, house.base),
        Band(house.ground - 0.2, house.ground, house.trim, 0.12 if house.historic else 0.03),
        Band(house.ground, house.eaves - 0.35, house.wall),
        Band(house.eaves - 0.35, house.eaves, house.trim, 0.28 if house.historic else 0.02),
    ]
    openings = np.concatenate([doorway, upper])
    parts = parts + wall(house.width, bands, openings, adjoining=True)
    parts += windows(upper, house.style, rng)
    if house.historic:
        parts += _relief(house, floors)
    parts.append(downpipes([0.5 * house.width - 0.12], house.eaves - 0.35, house.roof.gutter))
    return parts


def _balconies(house: _House, x: float, floors: Floats, rng: np.random.Generator) -> list[Panels]:
    bars = bool(rng.random() < 0.4) and len(floors) < 3
    parapet = house.trim if house.historic else palette.WHITE
    places = np.c_[np.full(len(floors), x), floors + 0.08]
    rail = palette.IRON if bars else parapet
    width = min(2.4, 2.0 * (0.5 * house.width - abs(x)), house.width / 3)
    return balconies(places, width, 0.95, house.trim, rail, bars=bars)


def _bay(house: _House, x: float, openings: Floats, rng: np.random.Generator) -> list[Panels]:
    """A box of rooms before the facade, with the windows that it hides in its own front."""
    half, out = 1.05, 0.75
    low, high = float(openings[0, 2]) - 0.8, float(openings[-1, 3]) + 0.5
    front = openings - (x, x, 0.0, 0.0)
    style = replace(house.style, lintel=False)
    parts = wall(2 * half, [Band(low, high, house.wall)], front) + windows(front, style, rng)
    parts = [part.at((x, -out, 0.0)) for part in parts]
    sides = ("front", "back", "top", "bottom")
    foot = 0.6 * half
    return [
        *parts,
        boxes(house.wall, (x - half, -out, low), (x + half, 0.0, high), without=sides),
        boxes(house.trim, (x - half - 0.1, -out - 0.1, high), (x + half + 0.1, 0.0, high + 0.25)),
        boxes(house.trim, (x - half - 0.05, -out - 0.05, low - 0.2), (x + half + 0.05, 0.0, low)),
        boxes(house.trim, (x - foot, -0.55 * out, low - 0.5), (x + foot, 0.0, low - 0.2)),
    ]


def _relief(house: _House, floors: Floats) -> list[Panels]:
    """String courses and pilasters at both ends."""
    half, high = 0.5 * house.width, house.eaves - 0.35
    ends = ("back", "top", "bottom")
    parts = [
        boxes(
            house.trim,
            [(-half, -0.07, house.ground), (half - 0.45, -0.07, house.ground)],
            [(0.45 - half, 0.0, high), (half, 0.0, high)],
            without=ends,
        )
    ]
    if len(floors) > 2:
        low, top = floors[1] - 0.1, floors[1] + 0.08
        course = boxes(house.trim, (-half, -0.1, low), (half, 0.0, top), without=("back",))
        parts.append(course)
    return parts


def _rear(house: _House, rng: np.random.Generator) -> list[Panels]:
    columns = evenly(house.width, 4.0, 12 // house.storeys)
    openings = grid(columns, 1.2 + house.storey * np.arange(house.storeys), 1.2, 1.4)
    openings = openings[openings[:, 3] < house.eaves - 0.2]
    face = palette.stucco(rng)
    style = replace(house.style.plain(), reveal=face)
    rear = wall(house.width, [Band(BELOW_GROUND, house.eaves, face)], openings)
    return rear + windows(openings, style, rng)


def _ground_floor(house: _House, rng: np.random.Generator) -> tuple[list[Panels], Floats]:
    """Windows and the entrance, and the openings they need."""
    columns = house.columns
    entrance = int(rng.integers(len(columns)))
    size = (1.2, 1.9) if house.historic else (1.5, 1.4)
    openings = grid(np.delete(columns, entrance), [1.25], *size)
    x, high = float(columns[entrance]), 2.9 if house.historic else 2.5
    door = np.array([[x - 0.65, x + 0.65, 0.3, high]])
    style = replace(house.style, lintel=False)
    parts = windows(openings, style, rng)
    parts += doors(door, palette.door_leaf(rng), house.trim, house.trim, recess=0.35, border=0.18)
    parts += steps(x, 1.7, 0.3, palette.STONE_SILL)
    return parts, np.concatenate([openings, door])


def _profile(house: _House, rng: np.random.Generator) -> Floats:
    if house.historic and rng.random() < 0.65:
        return mansard_profile(house.depth, house.eaves, 2.5, 0.15 * house.depth)
    pitch = float(rng.uniform(0.45, 0.8) if house.historic else rng.uniform(0.3, 0.6))
    return gable_profile(house.depth, house.eaves, 0.5 * house.depth * pitch, 0.3)


def _on_the_roof(house: _House, profile: Floats, rng: np.random.Generator) -> list[Panels]:
    (y0, z0), (y1, z1) = profile[:2]
    rise = (z1 - z0) / (y1 - y0)
    slope = Slope(z0 - y0 * rise, rise)
    edge = 0.5 * house.width
    parts = [gutters(house.roof.gutter, -edge, edge, y0, house.depth - y0, z0)]
    columns = evenly(house.width, 3.2, 4)
    mansard = len(profile) > 3
    if mansard or (rise > 0.55 and rng.random() < 0.6):
        front, size = (0.12, (1.4, 1.75)) if mansard else (0.9, (1.5, 1.3))
        cheeks = Material("sheet_metal", (0.3, 0.3, 0.3)) if rng.random() < 0.5 else house.wall
        parts += dormers(
            columns,
            front,
            slope,
            size,
            cheeks,
            house.style.frame,
            house.roof,
            int(rng.integers(7)),
            gabled=bool(rng.random() < 0.4) and not mansard,
        )
    elif rng.random() < 0.6:
        parts += skylights(columns[:2], 0.2 * house.depth, slope, palette.DARK_FRAME)
    ridge = profile[len(profile) // 2]
    body = Material(f"brick/{int(rng.integers(5))}")
    for side in (-1, 1)[: int(rng.integers(1, 3))]:
        x = side * (edge - 0.5)
        parts += chimney(x, ridge[0] + 0.5, ridge[1] - 1.5, ridge[1] + 0.9, body, palette.CONCRETE)
    return parts
