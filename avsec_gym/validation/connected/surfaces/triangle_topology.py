"""The edges of a closed triangle mesh, and a sphere of triangles to begin with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from avsec_gym.geometry import Floats

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Edges:
    """Each edge once, with the four others of its two triangles.

    Args:
        ends: The two vertices of each edge, shape (E, 2).
        neighbours: Numbers of edges, shape (E, 4): those of the one triangle in its order, which
            begins at the edge, then those of the other.
    """

    ends: Integers
    neighbours: Integers


def edges_of(triangles: Integers) -> Edges:
    """The edges of a closed mesh, in which each belongs to two triangles.

    Args:
        triangles: Three vertices each, shape (T, 3).
    """
    # Half an edge for each side of each triangle, by the rising numbers of its ends.
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    ends, edge = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    of_triangle = edge.reshape(-1, 3)
    following = np.stack([np.roll(of_triangle, -1, 1), np.roll(of_triangle, -2, 1)], axis=2)
    # The two halves of an edge stand beside each other.
    order = np.argsort(edge.ravel(), kind="stable")
    return Edges(ends, following.reshape(-1, 2)[order].reshape(-1, 4))


def subdivided(vertices: Floats, triangles: Integers) -> tuple[Floats, Integers]:
    """Each triangle becomes four, with new vertices in the middle of the edges."""
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    ends, edge = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    middle = len(vertices) + edge.reshape(-1, 3)
    (a, b, c), (ab, bc, ca) = triangles.T, middle.T
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    finer = np.concatenate([np.stack(corner, axis=1) for corner in corners])
    return np.concatenate([vertices, vertices[ends].mean(axis=1)]), finer


def sphere(subdivisions: int) -> tuple[Floats, Integers]:
    """An icosahedron whose triangles were divided so many times; vertices of length 1."""
    golden = (1 + np.sqrt(5)) / 2
    signs = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    pairs = np.c_[np.zeros(4), signs * [1.0, golden]]
    vertices = np.concatenate([np.roll(pairs, shift, axis=1) for shift in range(3)])
    hull = ConvexHull(vertices)
    # The hull's triangles, each turned so that it is counter-clockwise from outside.
    triangles = hull.simplices.astype(np.int64)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    is_inside_out = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    triangles[is_inside_out] = triangles[is_inside_out][:, ::-1]
    for _ in range(subdivisions):
        vertices, triangles = subdivided(vertices, triangles)
    return vertices / np.linalg.norm(vertices, axis=1, keepdims=True), triangles


def around_points(points: Floats, subdivisions: int) -> tuple[Floats, Integers]:
    """A sphere of triangles, shrunk onto the convex hull of points (N, 3).

    Raises:
        QhullError: The points lie in a plane.
    """
    hull = ConvexHull(points)
    directions, triangles = sphere(subdivisions)
    middle = points[hull.vertices].mean(axis=0)
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    # Along each direction, the nearest face that it leaves the hull by.
    outward = directions @ normals.T
    with np.errstate(divide="ignore"):
        reach = np.where(outward > 1e-9, -(normals @ middle + offsets) / outward, np.inf)
    return middle + directions * reach.min(axis=1, keepdims=True), triangles
