"""Flat plates with a picture on them: traffic signs, posters, boards."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.facets import facets
from avsec_gym.world.models.furniture.materials import ALUMINIUM
from avsec_gym.world.shapes import polygon


def plate(
    outline: ArrayLike,
    face: Material,
    back: Material = ALUMINIUM,
    *,
    thickness: float = 0.02,
    rim: Material = ALUMINIUM,
) -> Mesh:
    """A plate that faces -x, its centre at the origin.

    Args:
        outline: Convex, from the centre to the right and up as one looks at the face,
            counter-clockwise, shape (n, 2), metres.
        face: The material whose texture shows the picture once; it is laid on the outline's
            bounding box.
        back: Material of the far side, which shows its picture unmirrored too.
        thickness: Thickness of the plate, metres.
        rim: Material of the narrow sides.
    """
    corners = np.asarray(outline, float)
    low, high = corners.min(axis=0), corners.max(axis=0)
    front = -0.5 * thickness
    near = np.column_stack([np.full(len(corners), front), -corners[:, 0], corners[:, 1]])
    far = np.add(near, (thickness, 0.0, 0.0))
    uv = np.column_stack([corners[:, 0] - low[0], high[1] - corners[:, 1]])
    far_uv = np.column_stack([high[0] - corners[:, 0], high[1] - corners[:, 1]])
    sides = np.stack([near, np.roll(near, 1, axis=0), np.roll(far, 1, axis=0), far], axis=1)
    return merge(
        [polygon(near, face, uv), polygon(far[::-1], back, far_uv[::-1]), facets(sides, rim)]
    )


def board(width: float, height: float, face: Material, back: Material = ALUMINIUM) -> Mesh:
    """A rectangular `plate`."""
    half = np.array([0.5 * width, 0.5 * height])
    return plate(np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half, face, back)
