"""Where one ray through a pixel is not enough."""

from __future__ import annotations

import numpy as np

from avsec_gym.kernels import kernel
from avsec_gym.world.section import Surface

_VEGETATION = int(Surface.VEGETATION)


@kernel(error_model="numpy")
def edge_marks(light, faces, distances, normals, surfaces, width):
    """Which pixels need more rays, shape (n,).

    A pixel lies on an edge if a neighbour shows another surface, bend, distance or brightness.
    Foliage is all edges: there the sensor's own blur must do.

    Invariant: each pair of neighbours is looked at once, from its left or upper pixel, and marks
    both.

    Args:
        light: Linear light, exposed, shape (n, 3).
        faces: Faces that were hit, -1 for the sky, shape (n,).
        distances: Distances of the hits, metres, shape (n,).
        normals: Normals at the hits, shape (n, 3).
        surfaces: `Surface` of each pixel, shape (n,).
        width: Width of the image, pixels; n is a multiple of it.
    """
    marks = np.zeros(len(faces), np.bool_)
    for row in range(len(faces) // width):
        for column in range(width):
            i = row * width + column
            for j in (i + 1, i + width):
                if j >= len(faces) or (j == i + 1 and column + 1 == width):
                    continue
                leaves = surfaces[i] == _VEGETATION and surfaces[j] == _VEGETATION
                if not leaves and _differ(i, j, light, faces, distances, normals):
                    marks[i] = marks[j] = True
    return marks


@kernel(inline="always", error_model="numpy")
def _differ(i, j, light, faces, distances, normals):
    """Whether two neighbouring pixels show an edge; the cheap tests come first."""
    if faces[i] == faces[j]:
        # Textures are filtered, shadows half-shades: nothing within a face is sharper than that.
        return False
    if faces[i] < 0 or faces[j] < 0:
        return True
    near = min(distances[i], distances[j])
    if abs(distances[i] - distances[j]) > 0.03 * near:
        return True
    alike = (
        normals[i, 0] * normals[j, 0]
        + normals[i, 1] * normals[j, 1]
        + normals[i, 2] * normals[j, 2]
    )
    if alike < 0.9:
        return True
    one = light[i, 0] + light[i, 1] + light[i, 2]
    two = light[j, 0] + light[j, 1] + light[j, 2]
    return abs(one - two) > 0.35 * max(one, two) + 0.02
