"""The default surface: a Delaunay triangulation of the points as they are seen from above."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay, QhullError

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.surfaces.mesh import SurfaceMesh


def delaunay_mesh(
    points: Floats, thinning: float = 0.1, longest_edge: float = np.inf
) -> SurfaceMesh:
    """A 2.5D surface: heights over the triangles that fill the points' outline.

    A surface has one height at each place. Of the points on a side of a vehicle, which lie above
    each other, the highest in each cell stays, as what is compared is the surface seen from above.

    Args:
        points: Points in the frame of a region, z up, metres, shape (N, 3).
        thinning: Size of those cells, metres.
        longest_edge: Triangles with a longer edge, seen from above, span what was not seen and are
            left out, metres; infinite: none is.

    Returns:
        The mesh; empty where the points span no triangle.

    Example:
        >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 2]])
        >>> delaunay_mesh(corners).triangles.shape
        (2, 3)
    """
    vertices = highest_in_cells(points, thinning)
    if len(vertices) < 3:
        return SurfaceMesh.empty()
    try:
        # QJ is not wanted: it moves points. Points on one line have no triangulation.
        triangles = Delaunay(vertices[:, :2]).simplices.astype(np.int64)
    except QhullError:
        return SurfaceMesh.empty()
    if np.isfinite(longest_edge):
        corners = vertices[triangles][:, :, :2]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        triangles = triangles[edges.max(axis=1) <= longest_edge]
    return SurfaceMesh(vertices, triangles)


def highest_in_cells(points: Floats, cell: float) -> Floats:
    """The highest point of each square cell of the ground, shape (M, 3)."""
    columns = np.floor(points[:, :2] / cell).astype(np.int64)
    key = columns[:, 0] * (1 << 32) + columns[:, 1]
    order = np.lexsort((points[:, 2], key))
    is_last = np.diff(key[order], append=np.iinfo(np.int64).max) != 0
    return points[order[is_last]]
