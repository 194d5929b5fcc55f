"""How much two oriented boxes have in common: exact polygon clipping in float64 numba kernels.

Everything that compares boxes by intersection over union (average precision, non-maximum
suppression, training targets) takes it from here; `avsec_gym.geometry.bird_eye_iou` gives the same
by shapely and is the independent opinion.  A *rectangle* is a row ``x, y, length, width, heading``
in any plane, heading counted counter-clockwise from x.  `overlap_area` can be called from other
numba kernels; the functions on arrays wrap it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel

_MOST_VERTICES = 20
"""A half-plane leaves a polygon of n vertices at most 1.5 n, even one that rounding bent."""


def ground_rectangles(
    location: ArrayLike, dimensions: ArrayLike, rotation_y: ArrayLike
) -> NDArray[np.float64]:
    """The bottom faces of 3D boxes as rectangles in the camera's x-z plane.

    Args:
        location: Bottom centres in the camera frame, shape (N, 3).
        dimensions: Height, width, length, shape (N, 3).
        rotation_y: KITTI's yaw about the camera's y axis, shape (N,).

    Returns:
        Shape (N, 5): x, z, length, width, heading (``-rotation_y``, as z points left of x).
    """
    location, dimensions = np.asarray(location, float), np.asarray(dimensions, float)
    heading = -np.asarray(rotation_y, float)
    columns = (location[:, 0], location[:, 2], dimensions[:, 2], dimensions[:, 1], heading)
    return np.stack(columns, axis=-1)


def rectangle_overlap(rectangles: ArrayLike, others: ArrayLike) -> Floats:
    """Common area of every pair of rectangles.

    Args:
        rectangles: The rectangles, shape (N, 5).
        others: The other rectangles, shape (M, 5).

    Returns:
        Shape (N, M).

    Example:
        >>> rectangle_overlap([[0, 0, 4, 2, 0]], [[1, 0, 4, 2, 0], [0, 0, 4, 2, np.pi / 2]])
        array([[6., 4.]])
    """
    return _overlap_matrix(_rows(rectangles), _rows(others))


def rectangle_iou(rectangles: ArrayLike, others: ArrayLike) -> Floats:
    """Intersection over union of every pair of rectangles.

    Args:
        rectangles: The rectangles, shape (N, 5).
        others: The other rectangles, shape (M, 5).

    Returns:
        Shape (N, M), in [0, 1]; 0 where both areas are 0.
    """
    rows, other_rows = _rows(rectangles), _rows(others)
    common = _overlap_matrix(rows, other_rows)
    return _share(common, rows[:, 2] * rows[:, 3], other_rows[:, 2] * other_rows[:, 3])


def box_iou(
    location: ArrayLike,
    dimensions: ArrayLike,
    rotation_y: ArrayLike,
    other_location: ArrayLike,
    other_dimensions: ArrayLike,
    other_rotation_y: ArrayLike,
) -> Floats:
    """Intersection over union of the volumes of every pair of upright 3D boxes.

    Args:
        location: Bottom centres in the camera frame, shape (N, 3).
        dimensions: Height, width, length, shape (N, 3).
        rotation_y: The headings, shape (N,).
        other_location: The others' locations, shape (M, 3).
        other_dimensions: The others' dimensions, shape (M, 3).
        other_rotation_y: The others' headings, shape (M,).

    Returns:
        Shape (N, M), in [0, 1].
    """
    location, dimensions = np.asarray(location, float), np.asarray(dimensions, float)
    other_location = np.asarray(other_location, float)
    other_dimensions = np.asarray(other_dimensions, float)
    area = rectangle_overlap(
        ground_rectangles(location, dimensions, rotation_y),
        ground_rectangles(other_location, other_dimensions, other_rotation_y),
    )
    bottom, other_bottom = location[:, None, 1], other_location[None, :, 1]
    top = bottom - dimensions[:, None, 0]
    other_top = other_bottom - other_dimensions[None, :, 0]
    height = np.minimum(bottom, other_bottom) - np.maximum(top, other_top)
    return _share(area * np.maximum(height, 0), dimensions.prod(1), other_dimensions.prod(1))


def _rows(rectangles: ArrayLike) -> Floats:
    return np.ascontiguousarray(rectangles, np.float64).reshape(-1, 5)


def _share(common: Floats, sizes: Floats, other_sizes: Floats) -> Floats:
    union = sizes[:, None] + other_sizes[None, :] - common
    return np.divide(common, union, out=np.zeros_like(common), where=union > 0)


@kernel(nogil=True)
def _overlap_matrix(rectangles: Floats, others: Floats) -> Floats:
    result = np.empty((len(rectangles), len(others)))
    for i in range(len(rectangles)):
        for j in range(len(others)):
            result[i, j] = overlap_area(rectangles[i], others[j])
    return result


@kernel(nogil=True)
def overlap_area(one: Floats, other: Floats) -> float:
    """Common area of two rectangles, each of shape (5,): a numba kernel.

    The other rectangle is moved into the frame of the first and clipped at its four sides
    (Sutherland and Hodgman 1974), so coordinates stay small and the area exact to about 1e-14.
    """
    half_length, half_width = 0.5 * one[2], 0.5 * one[3]
    other_length, other_width = 0.5 * other[2], 0.5 * other[3]
    # Rectangles whose circles do not meet have no common area.
    dx, dy = other[0] - one[0], other[1] - one[1]
    reach = np.sqrt(half_length**2 + half_width**2) + np.sqrt(other_length**2 + other_width**2)
    if dx * dx + dy * dy >= reach * reach:
        return 0.0
    # The corners of the other rectangle in the frame of the first, counterclockwise.
    cos, sin = np.cos(one[4]), np.sin(one[4])
    x, y = cos * dx + sin * dy, cos * dy - sin * dx
    cos, sin = np.cos(other[4] - one[4]), np.sin(other[4] - one[4])
    polygon = np.empty((_MOST_VERTICES, 2))
    clipped = np.empty((_MOST_VERTICES, 2))
    for k in range(4):
        along = other_length if k in (0, 3) else -other_length
        across = other_width if k < 2 else -other_width
        polygon[k, 0] = x + cos * along - sin * across
        polygon[k, 1] = y + sin * along + cos * across
    # Invariant: the first `count` vertices of `polygon` are those of a convex polygon, what is left
    # of the other rectangle within the sides so far.
    count = 4
    for side in range(4):
        axis = side % 2
        sign = 1.0 if side < 2 else -1.0
        limit = half_length if axis == 0 else half_width
        kept = 0
        for k in range(count):
            following = k + 1 if k + 1 < count else 0
            here = limit - sign * polygon[k, axis]
            there = limit - sign * polygon[following, axis]
            if here >= 0.0:
                clipped[kept, 0], clipped[kept, 1] = polygon[k, 0], polygon[k, 1]
                kept += 1
            # An edge that crosses the side ends on it: exactly, so that no error adds up.
            if (here >= 0.0) != (there >= 0.0):
                part = here / (here - there)
                clipped[kept, axis] = sign * limit
                clipped[kept, 1 - axis] = polygon[k, 1 - axis] + part * (
                    polygon[following, 1 - axis] - polygon[k, 1 - axis]
                )
                kept += 1
        polygon, clipped, count = clipped, polygon, kept
        if count < 3:
            return 0.0
    # Triangles from the first vertex.
    twice = 0.0
    for k in range(1, count - 1):
        ax, ay = polygon[k, 0] - polygon[0, 0], polygon[k, 1] - polygon[0, 1]
        bx, by = polygon[k + 1, 0] - polygon[0, 0], polygon[k + 1, 1] - polygon[0, 1]
        twice += ax * by - ay * bx
    return 0.5 * abs(twice)
