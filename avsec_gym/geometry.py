"""Frames, rotations, projections and oriented boxes: pure functions, batch first.

Frames (metres, radians): the *camera frame* is KITTI's rectified one (x right, y down, z forward);
the *velodyne frame* has x forward, y left, z up; the *ego frame* of planning is the ground plane
with x forward and y left.  A pose in the ego frame is ``(x, y, heading)``, heading counted
counter-clockwise from x.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def wrap_angle(angle: ArrayLike) -> Floats:
    """The same direction in [-pi, pi).

    Example:
        >>> float(wrap_angle(3 * np.pi / 2))
        -1.5707963267948966
    """
    return np.asarray((np.asarray(angle, float) + np.pi) % (2 * np.pi) - np.pi)


def camera_to_ego(location: ArrayLike, rotation_y: ArrayLike) -> Floats:
    """Poses of labelled objects on the ground plane.

    Args:
        location: Bottom centres in the camera frame, shape (..., 3).
        rotation_y: KITTI's yaw about the camera's y axis, shape (...).

    Returns:
        Ego-frame poses, shape (..., 3): ``x = z``, ``y = -x``, ``heading = -(rotation_y + pi/2)``.
    """
    location = np.asarray(location, float)
    heading = wrap_angle(-(np.asarray(rotation_y, float) + np.pi / 2))
    return np.stack([location[..., 2], -location[..., 0], heading], axis=-1)


def ego_to_camera(poses: ArrayLike, height: ArrayLike) -> tuple[Floats, Floats]:
    """The inverse of `camera_to_ego`.

    Args:
        poses: Ego-frame poses, shape (..., 3).
        height: The camera's height above the object's bottom (the camera frame's y), shape (...).

    Returns:
        Locations (..., 3) in the camera frame and rotation_y (...).
    """
    poses = np.asarray(poses, float)
    y = np.broadcast_to(np.asarray(height, float), poses.shape[:-1])
    location = np.stack([-poses[..., 1], y, poses[..., 0]], axis=-1)
    return location, wrap_angle(-poses[..., 2] - np.pi / 2)


def rectangle_corners(poses: ArrayLike, length: ArrayLike, width: ArrayLike) -> Floats:
    """Corners of rectangles centred on poses, counter-clockwise from front left.

    Args:
        poses: The poses, shape (..., 3).
        length: Extent along the heading, shape (...) or broadcastable to it.
        width: Extent across the heading.

    Returns:
        Shape (..., 4, 2).
    """
    poses = np.asarray(poses, float)
    along = 0.5 * np.asarray(length, float)[..., None] * np.array([1.0, -1.0, -1.0, 1.0])
    across = 0.5 * np.asarray(width, float)[..., None] * np.array([1.0, 1.0, -1.0, -1.0])
    cos, sin = np.cos(poses[..., 2, None]), np.sin(poses[..., 2, None])
    x = poses[..., 0, None] + cos * along - sin * across
    y = poses[..., 1, None] + sin * along + cos * across
    return np.stack([x, y], axis=-1)


def rectangle_polygons(
    poses: ArrayLike, length: ArrayLike, width: ArrayLike
) -> NDArray[np.object_]:
    """`rectangle_corners` as shapely polygons, shape (...)."""
    return np.asarray(shapely.polygons(rectangle_corners(poses, length, width)))


def box_corners(location: ArrayLike, dimensions: ArrayLike, rotation_y: ArrayLike) -> Floats:
    """Corners of 3D boxes in the camera frame.

    Args:
        location: Bottom centres, shape (..., 3).
        dimensions: Height, width, length, shape (..., 3).
        rotation_y: The headings, shape (...).

    Returns:
        Shape (..., 8, 3): the bottom face counter-clockwise seen from above, then the top face.
    """
    location, dimensions = np.asarray(location, float), np.asarray(dimensions, float)
    height, width, length = (dimensions[..., i, None] for i in range(3))
    along = 0.5 * length * np.array([1, -1, -1, 1, 1, -1, -1, 1])
    across = 0.5 * width * np.array([1, 1, -1, -1, 1, 1, -1, -1])
    up = height * np.array([0, 0, 0, 0, 1, 1, 1, 1])
    angle = np.asarray(rotation_y, float)[..., None]
    cos, sin = np.cos(angle), np.sin(angle)
    x = location[..., 0, None] + cos * along + sin * across
    y = location[..., 1, None] - up
    z = location[..., 2, None] - sin * along + cos * across
    return np.stack([x, y, z], axis=-1)


def transform_points(transform: ArrayLike, points: ArrayLike) -> Floats:
    """Apply a rigid or affine transform.

    Args:
        transform: The transform, shape (3, 4) or (4, 4).
        points: The points, shape (..., 3).

    Returns:
        Shape (..., 3).
    """
    matrix = np.asarray(transform, float)
    return np.asarray(points, float) @ matrix[:3, :3].T + matrix[:3, 3]


def project(projection: ArrayLike, points: ArrayLike) -> tuple[Floats, Floats]:
    """Pinhole projection of camera-frame points.

    Args:
        projection: KITTI's 3x4 matrix P.
        points: The points, shape (..., 3), in the rectified frame of camera 0.

    Returns:
        Pixels (..., 2) as u, v, and depths (...); pixels of points with depth <= 0 are meaningless.
    """
    homogeneous = transform_points(projection, points)
    depth = homogeneous[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = homogeneous[..., :2] / depth[..., None]
    return pixels, depth


def bird_eye_iou(
    poses: ArrayLike, sizes: ArrayLike, other_poses: ArrayLike, other_sizes: ArrayLike
) -> Floats:
    """Intersection over union of every pair of rectangles on the ground plane.

    Args:
        poses: The poses, shape (N, 3).
        sizes: Length and width, shape (N, 2).
        other_poses: The others' poses, shape (M, 3).
        other_sizes: The others' sizes, shape (M, 2).

    Returns:
        Shape (N, M), in [0, 1].
    """
    sizes, other_sizes = np.asarray(sizes, float), np.asarray(other_sizes, float)
    one = rectangle_polygons(poses, sizes[:, 0], sizes[:, 1])
    two = rectangle_polygons(other_poses, other_sizes[:, 0], other_sizes[:, 1])
    # Most pairs lie too far apart to have anything in common.
    apart = np.asarray(poses, float)[:, None, :2] - np.asarray(other_poses, float)[None, :, :2]
    reach = 0.5 * (np.hypot(*sizes.T)[:, None] + np.hypot(*other_sizes.T))
    near = np.nonzero(np.hypot(apart[..., 0], apart[..., 1]) <= reach)
    common = np.zeros(reach.shape)
    common[near] = shapely.area(shapely.intersection(one[near[0]], two[near[1]]))
    return np.asarray(common / (shapely.area(one)[:, None] + shapely.area(two) - common))
