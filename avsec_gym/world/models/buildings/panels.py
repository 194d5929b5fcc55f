"""Flat panels by the hundred: what buildings are made of.

A part of a building is a few `Panels`, each many quadrilaterals of one material, made by one
NumPy expression; `solid` joins them into a mesh.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh

Floats = NDArray[np.floating]

_ONCE = np.array([(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)])

_TRIANGLES = np.array([(0, 1, 2), (0, 2, 3)], np.int32)

_UPRIGHT = np.array([(0, 2, 3), (1, 2, 3), (1, 2, 4), (0, 2, 4)])
"""x, y, z of a rectangle's corners among left, right, back, low, high."""

_SIDES = {
    "front": ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)),
    "right": ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)),
    "back": ((1, 1, 0), (0, 1, 0), (0, 1, 1), (1, 1, 1)),
    "left": ((0, 1, 0), (0, 0, 0), (0, 0, 1), (0, 1, 1)),
    "top": ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
    "bottom": ((0, 1, 0), (1, 1, 0), (1, 0, 0), (0, 0, 0)),
}
"""End of a box at which each corner of a side lies, along x, y, z; front is towards -y."""


@dataclass(frozen=True, eq=False)
class Panels:
    """Quadrilaterals of one material; a triangle repeats its last corner.

    Args:
        corners: Corners, counter-clockwise seen from outside, shape (n, 4, 3), metres.
        uv: Places of the corners on the texture, metres, shape (n, 4, 2).
        material: Material of all of them.
    """

    corners: Floats
    uv: Floats
    material: Material

    def at(self, places: ArrayLike) -> Panels:
        """Copies at many places, shape (k, 3)."""
        moves = np.asarray(places, float).reshape(-1, 1, 1, 3)
        corners = (self.corners[None] + moves).reshape(-1, 4, 3)
        return Panels(corners, np.tile(self.uv, (len(moves), 1, 1)), self.material)


def solid(parts: Iterable[Panels]) -> Mesh:
    """One mesh of all panels, with hard edges; panels without area vanish."""
    panels = [part for part in parts if len(part.corners)]
    index: dict[Material, int] = {}
    codes = [index.setdefault(part.material, len(index)) for part in panels]
    material = np.repeat(np.array(codes, np.int32), [len(part.corners) for part in panels])
    corners = np.concatenate([part.corners for part in panels])
    a, b, c, d = corners.transpose(1, 0, 2)
    normals = _unit(_cross(c - a, d - b))
    first = 4 * np.arange(len(corners), dtype=np.int32)[:, None]
    faces = np.concatenate([first + _TRIANGLES[0], first + _TRIANGLES[1]])
    areas = np.concatenate([_cross(b - a, c - a), _cross(c - a, d - a)])
    kept = np.abs(areas).max(axis=1) > 1e-6
    return Mesh(
        vertices=corners.reshape(-1, 3).astype(np.float32),
        normals=np.repeat(normals, 4, axis=0).astype(np.float32),
        uv=np.concatenate([part.uv for part in panels]).reshape(-1, 2).astype(np.float32),
        faces=faces[kept],
        material=np.tile(material, 2)[kept],
        materials=tuple(index),
    )


def upright(
    material: Material,
    x0: ArrayLike,
    x1: ArrayLike,
    z0: ArrayLike,
    z1: ArrayLike,
    *,
    y: ArrayLike = 0.0,
    once: bool = False,
) -> Panels:
    """Rectangles that face the street (-y), one for each entry of the arrays.

    Args:
        material: Material of all of them.
        x0: Left ends, metres.
        x1: Right ends, metres.
        z0: Lower ends.
        z1: Upper ends.
        y: Distance behind the facade's plane, metres.
        once: Whether each shows one whole repeat of a texture of 1 m x 1 m, not metres.
    """
    ends = np.array(np.broadcast_arrays(*np.atleast_1d(x0, x1, y, z0, z1)), float)
    corners = ends[_UPRIGHT].transpose(2, 0, 1)
    if once:
        return Panels(corners, np.tile(_ONCE, (len(corners), 1, 1)), material)
    return Panels(corners, corners[..., [0, 2]] * (1.0, -1.0), material)


def boxes(
    material: Material, low: ArrayLike, high: ArrayLike, without: tuple[str, ...] = ()
) -> Panels:
    """Boxes between two corners each.

    Args:
        material: Material of all sides.
        low: Left front lower corners, shape (n, 3) or (3,).
        high: Right rear upper corners, like `low`.
        without: Sides that are left out because they are never seen: front, right, back, left, top,
            bottom.
    """
    corner, axis = _shown(without)
    ends = np.stack(np.broadcast_arrays(np.atleast_2d(low), np.atleast_2d(high)), axis=1)
    corners = ends[:, corner, np.arange(3)].astype(float)
    uv = np.take_along_axis(corners, np.broadcast_to(axis, (len(corners), *axis.shape)), axis=-1)
    return Panels(corners.reshape(-1, 4, 3), uv.reshape(-1, 4, 2) * (1.0, -1.0), material)


def quads(material: Material, corners: ArrayLike) -> Panels:
    """Any flat quadrilaterals, shape (n, 4, 3); the first edge runs along the texture's u."""
    points = np.asarray(corners, float).reshape(-1, 4, 3)
    right = _unit(points[:, 1] - points[:, 0])
    across = _cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1])
    up = _unit(_cross(across, right))
    u = (points * right[:, None]).sum(axis=-1)
    v = -((points - points[:, :1]) * up[:, None]).sum(axis=-1)
    return Panels(points, np.stack([u, v], axis=-1), material)


def fan(material: Material, outline: ArrayLike) -> Panels:
    """A flat convex polygon, shape (n, 3), as quadrilaterals."""
    points = np.asarray(outline, float)
    corners = [
        (points[0], points[i], points[i + 1], points[min(i + 2, len(points) - 1)])
        for i in range(1, len(points) - 1, 2)
    ]
    result = quads(material, corners)
    return Panels(result.corners, _flat_uv(result.corners), material)


def slab(
    top: Material,
    corners: ArrayLike,
    thickness: float,
    *,
    under: Material,
    edge: Material,
    edges: tuple[int, ...] = (0, 1, 2, 3),
) -> list[Panels]:
    """A quadrilateral with thickness, downwards: roof plane, awning, canopy.

    Args:
        top: Material of the upper face.
        corners: Corners, counter-clockwise seen from above, the lowest edge first, shape (4, 3).
        thickness: Vertical, metres.
        under: Material of the lower face.
        edge: Material of the rim.
        edges: The edges that have a rim: edge i runs from corner i to the next.
    """
    upper = np.asarray(corners, float)
    lower = upper - (0.0, 0.0, thickness)
    rim = [
        (lower[i], lower[(i + 1) % 4], upper[(i + 1) % 4], upper[i])
        for i in edges
        if not np.array_equal(upper[i], upper[(i + 1) % 4])
    ]
    parts = [quads(top, upper[None]), quads(under, lower[[1, 0, 3, 2]][None])]
    return [*parts, quads(edge, rim)] if rim else parts


@functools.cache
def _shown(without: tuple[str, ...]) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """A box's shown sides: ends of their corners (s, 4, 3), axes of their textures (s, 4, 2)."""
    sides = [side for side in _SIDES if side not in without]
    axes = {"left": (1, 2), "right": (1, 2), "top": (0, 1), "bottom": (0, 1)}
    axis = np.array([[axes.get(side, (0, 2))] * 4 for side in sides])
    return np.array([_SIDES[side] for side in sides]), axis


def _flat_uv(corners: Floats) -> Floats:
    """Metres in the wall's own plane, from the ground, whichever way the wall looks."""
    spread = np.ptp(corners.reshape(-1, 3), axis=0)
    return corners[..., [0 if spread[0] >= spread[1] else 1, 2]] * (1.0, -1.0)


def _cross(first: Floats, second: Floats) -> Floats:
    """Cross products; several times as fast as NumPy's for a handful of vectors."""
    ahead, behind = [1, 2, 0], [2, 0, 1]
    return first[:, ahead] * second[:, behind] - first[:, behind] * second[:, ahead]


def _unit(vectors: Floats) -> Floats:
    return vectors / (np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True)) + 1e-12)
