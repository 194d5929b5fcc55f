"""What spans a road: sign gantries and bridges."""

from __future__ import annotations

import functools
from itertools import pairwise

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.fences import bar_fence
from avsec_gym.world.models.furniture.materials import CONCRETE, GALVANISED, GREY_CONCRETE
from avsec_gym.world.models.furniture.poles import DEPTH
from avsec_gym.world.models.furniture.sweep import swept
from avsec_gym.world.models.furniture.traffic_signs import sign_plate
from avsec_gym.world.shapes import box, grid, hard_edges

_GRASS = Material("grass/0")


@functools.cache
def sign_gantry(
    width: float = 16.0, clearance: float = 5.2, boards: tuple[str, ...] = ("gantry_0",)
) -> Mesh:
    """A gantry across a carriageway that carries direction signs facing -x.

    Args:
        width: Distance between its posts, which stand at y = +-width / 2, metres.
        clearance: Height of the signs' lower edges above the road, metres.
        boards: Names in `SIGN_FACES`, evenly spread from left to right.

    Raises:
        KeyError: There is no such sign.
    """
    top = clearance + 2.6
    posts = [
        box(0.35, 0.35, top + DEPTH, GALVANISED).placed(0, y, -DEPTH)
        for y in (-0.5 * width, 0.5 * width)
    ]
    feet = [
        box(0.9, 0.9, 0.35 + DEPTH, CONCRETE).placed(0, y, -DEPTH)
        for y in (-0.5 * width, 0.5 * width)
    ]
    beams = [
        box(0.2, width, 0.2, GALVANISED).placed(x, 0, top - z)
        for x in (-0.15, 0.15)
        for z in (0.4, 1.5)
    ]
    struts = [
        box(0.1, 0.08, 1.3, GALVANISED).placed(0, y, top - 1.6)
        for y in np.arange(2.0 - 0.5 * width, 0.5 * width, 2.0)
    ]
    places = 0.5 * width - width * (np.arange(len(boards)) + 0.5) / len(boards)
    signs = [
        sign_plate(name).placed(-0.32, y, clearance + 1.3)
        for name, y in zip(boards, places.tolist(), strict=True)
    ]
    return merge([*posts, *feet, *beams, *struts, *signs])


@functools.cache
def overpass(
    length: float = 60.0,
    width: float = 9.0,
    clearance: float = 4.8,
    *,
    opening: float = 26.0,
    bank: Material = _GRASS,
) -> Mesh:
    """A concrete bridge that carries a road across ours; its middle is over the origin.

    The deck, thinnest in mid-span, rests on slanting piers at both sides of an opening and on
    abutments at its ends, where banks go down on both sides.

    Args:
        length: Length along y, from abutment to abutment, metres.
        width: Width along x, metres.
        clearance: Lowest free height within the opening.
        opening: Free width between the piers, for the road below, metres.
        bank: Material of the slopes beside the abutments.
    """
    y = np.linspace(-0.5 * length, 0.5 * length, 17)
    # The underside bends down towards the piers.
    depth = 0.9 + 0.7 * np.clip(np.abs(y) / (0.5 * opening), 0.0, 1.0) ** 2
    top = clearance + depth[np.abs(y) <= 0.5 * opening + 1e-6].max()
    deck = _deck(y, depth, width, top)
    rails, kerbs = [], []
    for x in (-0.5 * width, 0.5 * width):
        edge = np.array([(x, -0.5 * length, top), (x, 0.5 * length, top)])
        kerbs.append(
            swept(edge, [(0.2, -0.45), (0.2, 0.12), (-0.2, 0.12), (-0.2, -0.45)], CONCRETE)
        )
        rails.append(bar_fence(np.add(edge, (0, 0, 0.12)), height=1.05, pitch=0.35))
    piers = [_pier(side, opening, width, clearance) for side in (-1.0, 1.0)]
    ends = [
        box(width, 1.2, top - 0.9 + DEPTH, GREY_CONCRETE).placed(
            0, side * (0.5 * length - 0.5), -DEPTH
        )
        for side in (-1, 1)
    ]
    banks = [_bank(side, length, width, top, bank) for side in (-1.0, 1.0)]
    return merge([deck, *kerbs, *rails, *piers, *ends, *banks])


def _deck(y: np.ndarray, depth: np.ndarray, width: float, top: float) -> Mesh:
    """A slab with a narrower underside (both along y), its edges overhanging."""
    rows = []
    for x, share in (
        (0.5, 0.0),
        (-0.5, 0.0),
        (-0.5, 0.35),
        (-0.32, 1.0),
        (0.32, 1.0),
        (0.5, 0.35),
        (0.5, 0.0),
    ):
        rows.append(np.column_stack([np.full(len(y), x * width), y, top - share * depth]))
    parts = [grid(np.stack(pair), None, CONCRETE) for pair in pairwise(rows)]
    return merge(parts)


def _pier(side: float, opening: float, width: float, height: float) -> Mesh:
    """A wall-like pier, its foot narrower than its head, leaning outwards."""
    y = side * (0.5 * opening + 0.5)
    base = np.array([(1, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)], float)
    rings = []
    for z, reach, thick in ((height + 0.5, 0.3 * width, 0.45), (-DEPTH, 0.2 * width, 0.35)):
        rings.append(np.column_stack([base[:, 0] * reach, y + base[:, 1] * thick, np.full(5, z)]))

    return hard_edges(grid(np.array(rings), None, GREY_CONCRETE))


def _bank(side: float, length: float, width: float, top: float, material: Material) -> Mesh:
    """Earth behind an abutment, 30 m long: slopes to both sides and towards our road."""
    run, end, below = 1.6 * top, 0.5 * length, -0.5
    x = np.array([-0.5 * width - run, -0.5 * width, 0.5 * width, 0.5 * width + run])
    crest = np.array([below, top - 0.05, top - 0.05, below])
    rows = [
        np.column_stack([x, np.full(4, side * y), level])
        for y, level in ((end - 0.6 * run, 0 * crest + below), (end, crest), (end + 30.0, crest))
    ]
    surface = np.stack(rows[:: int(side)], axis=1)
    return hard_edges(grid(surface, surface[..., :2], material))
