"""b*: the boxes that a patch is to make a detector see (thesis, equation 5.4)."""

from __future__ import annotations

import numpy as np

from avsec_gym.argument_checks import number
from avsec_gym.attacks.attack import LEFT
from avsec_gym.attacks.object_injection import GHOSTS
from avsec_gym.attacks.patch_placement import PatchPlace, focal_times_baseline
from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats, bird_eye_iou, box_corners, project, wrap_angle

FULL_CAR = GHOSTS["car"].dimensions
"""Height, width, length of KITTI's mean car, metres."""
GHOST_WIDTHS = (0.1, FULL_CAR[1])
"""Metres: from a thing of no name to a full car."""
_CAMERA_HEIGHT = 1.65
_AWAY = -np.pi / 2
"""The rotation_y of a ghost: as the ego vehicle drives."""


def ghost_box(
    place: PatchPlace,
    calibration: Calibration,
    width: float | None = None,
    camera_height: float = _CAMERA_HEIGHT,
) -> Boxes3D:
    """The ghost of a patch: a car that drives ahead, whose rear is where the patch stands.

    The middle of its rear has the patch's column and depth, as the visible side of a real car
    would.  Without a width, it is seen inside of the patch ("ghost 3D bounding boxes inside the
    patch", section 5.5.1): where a car would be seen larger, the ghost is a smaller one.  Detectors
    know no such cars, and answer with one of the usual size there.  It stands on the ground, lifted
    only as far as it must be for its rear to show the patch: to the patch's upper edge, or to its
    centre where the patch is higher than a car.

    Args:
        place: Place of the patch.
        calibration: Calibration of the cameras.
        width: Width of the ghost, metres, whatever the patch shows of it; its height and length are
            in the same proportion as those of `FULL_CAR`.  None: the width that the patch shows, up
            to that of `FULL_CAR`.
        camera_height: Height of the camera above the ground, metres.

    Returns:
        One Car with 2D box, truncation 0, occlusion 0 and alpha, as labels have them.

    Raises:
        ConfigurationError: The width is not one of `GHOST_WIDTHS`.
    """
    projection = calibration.projection(LEFT)
    depth = focal_times_baseline(calibration) / place.disparity
    seen = depth * np.array([place.u, place.v, 1.0])
    x, y, z = np.linalg.solve(projection[:, :3], seen - projection[:, 3])
    radius = place.radius * depth / projection[1, 1]
    seen_width = min(FULL_CAR[1], 2 * radius) if width is None else ghost_width(width)
    height, width, length = np.array(FULL_CAR) * (seen_width / FULL_CAR[1])
    bottom = min(camera_height, y + max(height - radius, height / 2))
    location = np.array([[x, bottom, z + length / 2]])
    rotation_y = np.array([_AWAY])
    return Boxes3D(
        location,
        np.array([[height, width, length]]),
        rotation_y,
        np.ones(1),
        np.array(["Car"]),
        box2d=_projected(projection, location, np.array([[height, width, length]]), rotation_y),
        truncation=np.zeros(1),
        occlusion=np.zeros(1),
        alpha=wrap_angle(rotation_y - np.arctan2(location[:, 0], location[:, 2])),
        moving=np.zeros(1, bool),
    )


def ghost_width(value: float) -> float:
    """The width of a ghost, metres, as `ghost_box` takes it.

    Raises:
        ConfigurationError: It is not one of `GHOST_WIDTHS`.

    Example:
        >>> ghost_width(1)
        1.0
    """
    return number("ghost_width", value, *GHOST_WIDTHS)


def target_boxes(
    place: PatchPlace,
    calibration: Calibration,
    truth: Boxes3D | None = None,
    width: float | None = None,
) -> Boxes3D:
    """b* of a scene: the ghost, beside what is really there.

    Args:
        place: Place of the patch.
        calibration: Calibration of the cameras.
        truth: The real objects that the detector is still to see; those whose place the ghost
            takes, or whose middle the patch hides, are left out.  None: the ghost alone.
        width: Width of the ghost, see `ghost_box`.
    """
    ghost = ghost_box(place, calibration, width)
    if truth is None or not len(truth):
        return ghost
    overlap = bird_eye_iou(
        truth.poses,
        np.column_stack([truth.length, truth.width]),
        ghost.poses,
        np.column_stack([ghost.length, ghost.width]),
    )[:, 0]
    middle = truth.location - [0.0, 0.5, 0.0] * truth.dimensions[:, :1]
    pixels, depth = project(calibration.projection(LEFT), middle)
    is_hidden = (depth > 0) & (np.hypot(*(pixels - [place.u, place.v]).T) < place.radius)
    return Boxes3D.concatenate([truth[(overlap == 0) & ~is_hidden], ghost])


def _projected(
    projection: Floats, location: Floats, dimensions: Floats, rotation_y: Floats
) -> Floats:
    pixels, _ = project(projection, box_corners(location, dimensions, rotation_y))
    return np.hstack([pixels.min(axis=1), pixels.max(axis=1)])
