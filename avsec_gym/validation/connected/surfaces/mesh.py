"""`SurfaceMesh`: triangles that stand for the surface of what was scanned."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """sm_{i,j}: the surface mesh of a region as a vehicle scanned it.

    Args:
        vertices: The corners of its triangles, frame of the region, metres, shape (V, 3).
        triangles: Three numbers of vertices each, shape (T, 3).
    """

    vertices: Floats
    triangles: NDArray[np.int64]

    @classmethod
    def empty(cls) -> SurfaceMesh:
        """No surface: too little was seen."""
        return cls(np.zeros((0, 3)), np.zeros((0, 3), np.int64))


Mesher = Callable[[Floats], SurfaceMesh]
"""Makes a mesh of points in a region's frame, shape (N, 3); an empty one of too few."""
