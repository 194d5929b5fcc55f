"""A vehicle's skin: sections from one side over the top to the other, bent round both ends."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh

_ANGLES = np.deg2rad([0.0, 8.0, 17.0, 28.0, 40.0, 53.0, 67.0, 82.0])
"""Angles of the columns round a corner, from the centre line to the side."""


@dataclass(frozen=True)
class Outline:
    """Left half of a plan: K columns from the rear centre line round the side to the front's.

    Args:
        x: Coordinates of the columns, metres, shape (K,).
        y: Share of the half width, shape (K,).
        front: Share of the front end's motion that each column follows: 1 at the front, 0 on the
            side.
        rear: The same for the rear end.
    """

    x: Floats
    y: Floats
    front: Floats
    rear: Floats


def outline(
    rear: float,
    front: float,
    rear_round: float,
    front_round: float,
    stations: ArrayLike,
    *,
    squareness: float = 2.8,
) -> Outline:
    """A plan with rounded ends (superellipses).

    Args:
        rear: Rear end, metres.
        front: Front end.
        rear_round: Length over which the rear end narrows.
        front_round: Length over which the front end narrows.
        stations: Coordinates of the columns wanted on the side, increasing, shape (n,).
        squareness: Exponent of the corners: 2 is an ellipse, 8 nearly a box.
    """
    side = np.asarray(stations, float)
    reach = np.cos(_ANGLES) ** (2.0 / squareness)
    front_columns = front - front_round * (1.0 - reach[::-1])
    rear_columns = rear + rear_round * (1.0 - reach)
    x = np.concatenate(
        [
            rear_columns[rear_columns < side[0] - 0.02],
            side,
            front_columns[front_columns > side[-1] + 0.02],
        ]
    )
    to_front = np.clip((x - (front - front_round)) / front_round, 0.0, 1.0)
    to_rear = np.clip(((rear + rear_round) - x) / rear_round, 0.0, 1.0)
    y = (1.0 - np.maximum(to_front, to_rear) ** squareness) ** (1.0 / squareness)
    return Outline(x, y, to_front**2, to_rear**2)


@dataclass(frozen=True, eq=False)
class Skin:
    """A grid of points over a vehicle, with its normals.

    Args:
        points: Sections from the right lower edge over the top to the left one, counted from the
            rear to the front, shape (K, 2 J + D, 3): J rows on each side, D across the top.
        normals: Outward normals, the same shape.
        rows: J.
        solid: Whether each triangle has not shrunk to a line, shape (2, K - 1, 2 J + D - 1);
            unknown if None.
    """

    points: Floats
    normals: Floats
    rows: int
    solid: NDArray[np.bool_] | None = None

    @property
    def left(self) -> Floats:
        """Points of the left side from the lower edge upwards, shape (K, J, 3)."""
        return self.points[:, : -self.rows - 1 : -1]

    def panel(
        self,
        material: Material,
        columns: slice,
        across: slice,
        uv: Floats | None = None,
    ) -> Mesh:
        """One rectangle of the grid as a mesh; `uv` has the shape of the rectangle, or is x, y."""
        points, normals = self.points[columns, across], self.normals[columns, across]
        solid = None
        if self.solid is not None:
            shape = self.points.shape[:2]
            first, last = _ends(columns, shape[0])
            low, high = _ends(across, shape[1])
            solid = self.solid[:, first:last, low:high]
        return surface(points, normals, material, uv, solid)


def _ends(part: slice, count: int) -> tuple[int, int]:
    """First and last of the points in a slice: the faces between them."""
    first, stop, _ = part.indices(count)
    return first, stop - 1


def skin(left: Floats, across: ArrayLike = (), crown: float | Floats = 0.0) -> Skin:
    """The whole from its left side.

    Args:
        left: Left side from the lower edge upwards, shape (K, J, 3), the first and last column on
            the centre line.
        across: Places of the points between the two upper edges, shares of the width from right to
            left, shape (D,).
        crown: Height of the middle above the edges, metres, for each column or for all.
    """
    right = left * [1.0, -1.0, 1.0]
    share = np.asarray(across, float)[None, :, None]
    top = right[:, -1:] * (1.0 - share) + left[:, -1:] * share
    rise = np.broadcast_to(np.asarray(crown, float), len(left))[:, None]
    # The crown fades towards the ends.
    place = left[:, -1, 0]
    along = 2.0 * (place - place[0]) / (place[-1] - place[0]) - 1.0
    fading = 1.0 - np.minimum(np.abs(along), 1.0)[:, None] ** 5
    top[..., 2] += rise * fading * (1.0 - (2.0 * share[..., 0] - 1.0) ** 2)
    points = np.concatenate([right, top, left[:, ::-1]], axis=1)
    return Skin(points, grid_normals(points), left.shape[1], _solid(points))


def grid_normals(points: Floats) -> Floats:
    """Normals of a grid, its faces weighted by area, so that large panels stay flat.

    Args:
        points: Points of the grid, shape (n, m, 3); a first or last row on the plane of symmetry
            gets normals in it.
    """
    first = points[1:, 1:] - points[:-1, :-1]
    second = points[:-1, 1:] - points[1:, :-1]
    faces = np.zeros((points.shape[0] + 1, points.shape[1] + 1, 3))
    faces[1:-1, 1:-1] = _cross(first, second)
    total = faces[:-1, :-1] + faces[1:, :-1] + faces[:-1, 1:] + faces[1:, 1:]
    for row in (0, -1):
        if np.abs(points[row, :, 1]).max() < 1e-6:
            total[row, :, 1] = 0.0
    length = np.sqrt(np.einsum("...i,...i", total, total))
    # Where the grid has shrunk to a point any direction will do.
    total[length < 1e-12] = (0.0, 0.0, 1.0)
    return np.asarray(total / np.where(length < 1e-12, 1.0, length)[..., None])


def surface(
    points: Floats,
    normals: Floats,
    material: Material,
    uv: Floats | None = None,
    solid: NDArray[np.bool_] | None = None,
) -> Mesh:
    """A grid of points with known normals as a mesh; without `uv` the texture lies on x and y.

    Args:
        points: Points of the grid, shape (n, m, 3), outside as in `shapes.grid`.
        normals: Normals at the points, shape (n, m, 3).
        material: Material of all faces.
        uv: Places on the texture, metres, shape (n, m, 2).
        solid: Whether each triangle is kept, shape (2, n - 1, m - 1); those with an area if None.
    """
    if solid is None:
        solid = _solid(points)
    faces = _grid_faces(*points.shape[:2])[solid.ravel()]
    return Mesh(
        points.reshape(-1, 3).astype(np.float32),
        normals.reshape(-1, 3).astype(np.float32),
        (points[..., :2] if uv is None else uv).reshape(-1, 2).astype(np.float32),
        faces,
        np.zeros(len(faces), np.int32),
        (material,),
    )


def _solid(points: Floats) -> NDArray[np.bool_]:
    """Which triangles of a grid have an area, in the order of `_grid_faces`."""
    across = points[1:, 1:] - points[:-1, :-1]
    halves = [
        _cross(points[1:, :-1] - points[:-1, :-1], across),
        _cross(across, points[:-1, 1:] - points[:-1, :-1]),
    ]
    return np.asarray(np.abs(np.stack(halves)).max(axis=-1) > 1e-9)


@functools.cache
def _grid_faces(rows: int, columns: int) -> NDArray[np.int32]:
    index = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    a, b = index[:-1, :-1].ravel(), index[1:, :-1].ravel()
    c, d = index[1:, 1:].ravel(), index[:-1, 1:].ravel()
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def _cross(a: Floats, b: Floats) -> Floats:
    """As `numpy.cross`, several times faster for arrays of this size."""
    result = np.empty_like(a)
    result[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    result[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    result[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return result


def on_side(left: Floats, column: ArrayLike, height: ArrayLike) -> Floats:
    """Points of a vehicle's left side at given heights.

    Args:
        left: Left side, shape (K, J, 3), heights growing with the second index.
        column: Column between 0 and K - 1, shape (...).
        height: Height, metres, the same shape; kept within the section.

    Returns:
        Shape (..., 3).
    """
    where, level = np.broadcast_arrays(np.asarray(column, float), np.asarray(height, float))
    shape = where.shape
    before = np.clip(where.ravel().astype(int), 0, len(left) - 2)
    share = (where.ravel() - before)[:, None, None]
    section = (1.0 - share) * left[before] + share * left[before + 1]
    z = section[..., 2]
    row = np.clip((z <= level.ravel()[:, None]).sum(axis=1) - 1, 0, left.shape[1] - 2)
    each = np.arange(len(row))
    low, high = section[each, row], section[each, row + 1]
    part = (level.ravel() - low[:, 2]) / np.maximum(high[:, 2] - low[:, 2], 1e-9)
    return np.asarray(low + np.clip(part, 0.0, 1.0)[:, None] * (high - low)).reshape(*shape, 3)


def patch(
    left: Floats,
    columns: ArrayLike,
    low: ArrayLike,
    high: ArrayLike,
    material: Material,
    *,
    lifted: float = 0.012,
    rows: int = 3,
    uv_size: tuple[float, float] | None = None,
) -> Mesh:
    """Something that lies on the left side or an end: a lamp, a grille half, a bumper strip.

    Args:
        left: Left side, shape (K, J, 3).
        columns: Columns from rear to front, shape (n,).
        low: Lower edge at each column, metres, shape (n,) or one for all.
        high: Upper edge.
        material: Material of the patch.
        lifted: Distance from the skin, metres.
        rows: Points between the edges.
        uv_size: Stretch the texture of this size over the patch once.
    """
    given = np.asarray(columns, float)
    # The skin's own columns between the given ones keep the patch from cutting its corners.
    own = np.arange(np.ceil(given[0] + 0.15), given[-1] - 0.15)
    place = np.sort(np.concatenate([given, own]))
    share = np.linspace(0.0, 1.0, rows)
    bottom = np.interp(place, given, np.broadcast_to(low, given.shape))
    top = np.interp(place, given, np.broadcast_to(high, given.shape))
    height = bottom[:, None] + share * (top - bottom)[:, None]
    # Counted from the front and upwards: columns cross rows outward.
    points = on_side(left, place[:, None], height)[:, ::-1]
    normals = grid_normals(points)
    uv = None
    if uv_size is not None:
        u = uv_size[0] * ((given[-1] - place) / (given[-1] - given[0]))[:, None]
        v = uv_size[1] * (1.0 - share[::-1])[None, :]
        uv = np.stack(np.broadcast_arrays(u, v), axis=-1)
    return surface(points + lifted * normals, normals, material, uv)


def column_at(left: Floats, row: int, distance: ArrayLike, *, front: bool) -> Floats:
    """Columns at distances along the skin from the centre line of the front or rear end.

    Args:
        left: Left side, shape (K, J, 3).
        row: Row along which the distance is measured.
        distance: Distance from the end, metres, shape (n,).
        front: Whether the distance counts from the front end; else from the rear one.
    """
    line = left[::-1, row] if front else left[:, row]
    steps = np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    place = np.interp(np.asarray(distance, float), along, np.arange(len(line)))
    return np.asarray(len(line) - 1 - place if front else place)
