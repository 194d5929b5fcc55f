"""Rings: cross-sections along limbs and tubes, of which bodies and bicycles are made."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material


@dataclass(frozen=True, eq=False)
class Rings:
    """N rings of M points each; consecutive rings are joined by a band of faces.

    Args:
        centres: Centres, shape (N, 3), metres.
        along: Direction in which the rings advance, shape (N, 3), of any length.
        front: Rough direction of a ring's front, shape (N, 3).
        sizes: Half sizes to the front, to the back and to the sides, shape (N, 3), metres.
        give: Displacement of a ring for each unit of the three loosenesses (along x, y, z), shape
            (N, 3).
        joined: Whether a ring continues the one before, shape (N,).
        codes: Material of the band between this ring and the one before, shape (N, M).
        materials: Materials of the codes.
        squareness: Shape of the cross section from 0 for ovals to 1 for rectangles, shape (N,).
        swell: Growth of front and back for each unit of looseness along x, shape (N,).
        bulge: Factor by which the points are farther out than the oval, shape (N, M).
        uv: Places on the texture, metres, shape (N, M + 1, 2); None for lengths round and along.
    """

    centres: Floats
    along: Floats
    front: Floats
    sizes: Floats
    give: Floats
    joined: NDArray[np.bool_]
    codes: NDArray[np.int32]
    materials: tuple[Material, ...]
    squareness: Floats
    swell: Floats
    bulge: Floats | None = None
    uv: Floats | None = None

    def carried(self, rotation: Floats, shift: Floats, give: ArrayLike = 0.0) -> Rings:
        """Turned about the origin, then moved: a rigid thing with one give."""
        turn = rotation.T
        gives = np.empty_like(self.give)
        gives[...] = give
        return replace(
            self,
            centres=self.centres @ turn + shift,
            along=self.along @ turn,
            front=self.front @ turn,
            give=gives,
        )


def sweep(
    centres: Floats,
    along: ArrayLike,
    front: ArrayLike,
    sizes: ArrayLike,
    materials: Material | Sequence[Material],
    *,
    sides: int = 8,
    codes: ArrayLike = 0,
    give: ArrayLike = 0.0,
    squareness: float = 0.0,
    swell: ArrayLike = 0.0,
    capped: bool = True,
) -> Rings:
    """Rings along a path, each an oval whose front and back may differ.

    Args:
        centres: Centres of the rings, shape (n, 3), metres.
        along: The path's direction, shape (n, 3) or (3,).
        front: Rough direction of the front of the ring, shape (n, 3) or (3,).
        sizes: Half sizes to the front, to the back and to the sides, shape (n, 3) or (3,),
            metres.
        materials: Material of the rings, or several.
        sides: Points of a ring.
        codes: Codes of the materials, shape (n, sides), (n, 1) or a number.
        give: Displacement of the rings, see `Rings`, shape (n, 3) or (3,).
        squareness: Shape of the cross section, see `Rings`.
        swell: Growth by looseness, see `Rings`, shape (n,) or a number.
        capped: Whether a point ring closes each end.
    """
    count = len(centres)
    index = _ends_twice(count) if capped else slice(None)
    half = _rows(sizes, (count, 3))[index]
    if capped:
        half[[0, -1]] = 0.0
    directions = _rows(along, (count, 3)), _rows(front, (count, 3)), _rows(give, (count, 3))
    total = len(half)
    return Rings(
        centres[index],
        directions[0][index],
        directions[1][index],
        half,
        directions[2][index],
        np.arange(total) > 0,
        _rows(codes, (count, sides))[index].astype(np.int32),
        (materials,) if isinstance(materials, Material) else tuple(materials),
        np.full(total, squareness),
        _rows(swell, (count,))[index],
    )


def rods(
    starts: Floats,
    ends: Floats,
    radius: ArrayLike,
    material: Material,
    *,
    sides: int = 5,
    give: tuple[ArrayLike, ArrayLike] = (0.0, 0.0),
) -> Rings:
    """Straight round bars: frame tubes, spokes, straps.

    Args:
        starts: Start points, shape (k, 3), metres.
        ends: End points, shape (k, 3), metres.
        radius: Radii, shape (k,) or one for all, metres.
        material: Material of all.
        sides: Number of sides of the cross-section's polygon.
        give: Displacements of starts and of ends, each of shape (k, 3) or (3,).
    """
    count = len(starts)
    direction = ends - starts
    steep = np.abs(direction[:, 2:]) > 2.0 * np.abs(direction[:, :2]).max(axis=1, keepdims=True)
    front = np.where(steep, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
    first, last = (_rows(part, (count, 3)) for part in give)
    rings = sweep(
        np.stack([starts, ends], axis=1).reshape(-1, 3),
        direction.repeat(2, axis=0),
        front.repeat(2, axis=0),
        _rows(radius, (count,)).repeat(2)[:, None].repeat(3, axis=1),
        material,
        sides=sides,
        give=np.stack([first, last], axis=1).reshape(-1, 3),
        capped=False,
    )
    return replace(rings, joined=np.arange(2 * count) % 2 == 1)


def unit(vectors: ArrayLike) -> Floats:
    """Vectors of length 1."""
    values = np.asarray(vectors, float)
    length = np.sqrt(np.einsum("...i,...i->...", values, values))[..., None]
    return np.asarray(values / np.maximum(length, 1e-9))


def interpolated(places: Floats, known: Floats, table: Floats) -> Floats:
    """Rows of a table at places between the known ones (which ascend); beyond, its end rows.

    Args:
        places: Places at which values are wanted, shape (n,).
        known: Places of the table's rows, shape (k,), k >= 2.
        table: Values at the known places, shape (k, m).

    Returns:
        Shape (n, m).
    """
    index = known.searchsorted(places).clip(1, len(known) - 1) - 1
    share = (places - known[index]) / (known[index + 1] - known[index])
    return np.asarray(table[index] + share.clip(0, 1)[:, None] * (table[index + 1] - table[index]))


@functools.cache
def _ends_twice(count: int) -> NDArray[np.int64]:
    return np.arange(-1, count + 1).clip(0, count - 1)


def _rows(values: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """np.broadcast_to, quicker."""
    rows = np.empty(shape)
    rows[...] = values
    return rows
