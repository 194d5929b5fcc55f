"""A surface mesh becomes a grid of heights, dsm_{i,j} (thesis, section 4.4.3)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.validation.connected.surfaces.mesh import SurfaceMesh

CELL = 0.1
"""Metres: the thesis' resolution, which it takes from MV3D."""
_ROUNDING = 1e-9


def surface_grid(mesh: SurfaceMesh, length: float, width: float, cell: float = CELL) -> Floats:
    """The height of a surface at the centre of each cell of a region.

    Where surfaces lie above each other, as they do in a closed mesh, the highest counts: the grid
    is what is seen from above.

    Args:
        mesh: The mesh, in the frame of the region.
        length: Extent of the grid along the region's x, centred, metres.
        width: Extent of the grid along its y.
        cell: Size of a cell, metres.

    Returns:
        Shape (length / cell, width / cell), rounded up; NaN where there is no surface.
    """
    shape = (max(1, math.ceil(length / cell - 1e-6)), max(1, math.ceil(width / cell - 1e-6)))
    heights = np.full(shape, np.nan)
    if len(mesh.triangles):
        _raise_to_triangles(heights, mesh.vertices, mesh.triangles, cell)
    return heights


@kernel(nogil=True)
def _raise_to_triangles(
    heights: Floats, vertices: Floats, triangles: NDArray[np.int64], cell: float
) -> None:
    # Invariant: a cell holds the highest of the triangles before t at its centre; NaN: none.
    rows, columns = heights.shape
    # Centre of cell (0, 0).
    x_0, y_0 = -(rows - 1) / 2 * cell, -(columns - 1) / 2 * cell
    for t in range(len(triangles)):
        a, b, c = vertices[triangles[t, 0]], vertices[triangles[t, 1]], vertices[triangles[t, 2]]
        twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        # An upright triangle covers no cell when it is seen from above.
        if abs(twice_area) < 1e-12:
            continue
        # The cells whose centres can lie in it.
        left, right = min(a[0], b[0], c[0]) - x_0, max(a[0], b[0], c[0]) - x_0
        low, high = min(a[1], b[1], c[1]) - y_0, max(a[1], b[1], c[1]) - y_0
        first_row = int(max(0.0, math.ceil(left / cell - _ROUNDING)))
        last_row = int(min(rows - 1.0, math.floor(right / cell + _ROUNDING)))
        first_column = int(max(0.0, math.ceil(low / cell - _ROUNDING)))
        last_column = int(min(columns - 1.0, math.floor(high / cell + _ROUNDING)))
        for i in range(first_row, last_row + 1):
            x = x_0 + i * cell
            for j in range(first_column, last_column + 1):
                y = y_0 + j * cell
                # Barycentric coordinates of the cell's centre; outside if one is negative.
                of_b = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / twice_area
                of_c = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / twice_area
                of_a = 1.0 - of_b - of_c
                if of_a < -_ROUNDING or of_b < -_ROUNDING or of_c < -_ROUNDING:
                    continue
                height = of_a * a[2] + of_b * b[2] + of_c * c[2]
                if not heights[i, j] >= height:
                    heights[i, j] = height
