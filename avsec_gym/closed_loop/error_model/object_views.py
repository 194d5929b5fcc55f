"""How well a camera sees each object: how far it is, what hides it, what lies outside the view."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, rectangle_corners, wrap_angle
from avsec_gym.kernels import kernel

HALF_VIEW = 0.711
"""Half the horizontal angle of KITTI's colour cameras, radians: 621 pixels of 721.5 to one."""
RAYS = 16
"""Directions across each object in which something nearer is looked for."""


@dataclass(frozen=True, eq=False)
class ObjectViews:
    """Views of N objects from the camera.

    Args:
        distance: Distance of each centre along the ground, metres, shape (N,).
        bearing: Direction of each centre, radians from straight ahead to the left, shape (N,).
        hidden: Share of each object's width behind nearer objects, shape (N,).
        outside: Share of each object's width outside the image, shape (N,).
    """

    distance: Floats
    bearing: Floats
    hidden: Floats
    outside: Floats


def object_views(boxes: Boxes3D, half_view: float = HALF_VIEW) -> ObjectViews:
    """How a camera at the origin sees objects, by their outlines on the ground alone.

    Heights do not count: a car behind a car is hidden, whatever looks out over it.

    Args:
        boxes: The objects, all that may hide one another.
        half_view: Half the horizontal angle of the image, radians.

    Example:
        >>> object_views(Boxes3D.empty()).hidden.shape
        (0,)
    """
    poses = boxes.poses
    # Widths as seen: the angles between the outermost corners, around the direction of the centre.
    corners = rectangle_corners(poses, boxes.length, boxes.width)
    bearing = np.arctan2(poses[:, 1], poses[:, 0])
    apart = wrap_angle(np.arctan2(corners[..., 1], corners[..., 0]) - bearing[:, None])
    right, left = apart.min(axis=1, initial=0.0), apart.max(axis=1, initial=0.0)
    rays = right[:, None] + (left - right)[:, None] * (np.arange(RAYS) + 0.5) / RAYS
    rays = wrap_angle(bearing[:, None] + rays)
    # An object hides another one where a ray to the farther one meets the nearer one's width.
    distance = np.hypot(poses[:, 0], poses[:, 1])
    return ObjectViews(
        distance,
        bearing,
        _hidden(rays, distance, bearing, right, left),
        (np.abs(rays) > half_view).mean(axis=1) if len(boxes) else np.zeros(0),
    )


@kernel(nogil=True)
def _hidden(rays: Floats, distance: Floats, bearing: Floats, right: Floats, left: Floats) -> Floats:
    """The share of each object's rays, shape (N, RAYS), that meet a nearer one's width, (N,)."""
    count = len(rays)
    shares = np.zeros(count)
    for i in range(count):
        # Invariant: `met` counts each ray of object i once, however many objects it meets.
        met = 0
        for k in range(RAYS):
            for j in range(count):
                if distance[j] < distance[i]:
                    turned = (rays[i, k] - bearing[j] + np.pi) % (2.0 * np.pi) - np.pi
                    if right[j] <= turned <= left[j]:
                        met += 1
                        break
        shares[i] = met / RAYS
    return shares
