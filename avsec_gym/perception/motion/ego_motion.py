"""How the ego vehicle moved between two frames, from its own cameras: stereo visual odometry."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Image, SensorFrame
from avsec_gym.geometry import Floats

Float32s = NDArray[np.float32]

_CORNERS, _QUALITY, _SPACING = 1500, 0.004, 8
"""Corners and quality and spacing of Shi and Tomasi's corners."""
_WINDOW, _LEVELS = 21, 4
"""Window and levels of Lucas and Kanade's tracker, pixels and halvings."""
_ROUND_TRIP = 0.5
"""Pixels that a corner may be off when it is tracked there and back."""
_EPIPOLAR, _LEAST_DISPARITY = 1.0, 2.0
"""Pixels between the rows of a rectified pair; nearer than about 200 m."""
_REPROJECTION, _TRIALS = 1.0, 500
_LEAST_INLIERS, _LEAST_SHARE = 40, 0.4


def ego_motion(
    now: SensorFrame,
    before: SensorFrame,
    ignored: Floats | None = None,
    left: int = 2,
    right: int = 3,
) -> Floats | None:
    """Where the earlier camera frame sees what stands still now.

    Corners of the current left image get their depth from the right image and are found again in
    the earlier left image; the motion that most of them agree on is the ego vehicle's.

    Args:
        now: The current frame, with both images.
        before: The earlier frame, with a left image.
        ignored: Left, top, right, bottom of areas without corners (objects that may move
            themselves), shape (N, 4), pixels.
        left: Reference camera.
        right: The other one.

    Returns:
        From the current to the earlier rectified camera frame, shape (4, 4); None where an image
        is missing, or too few corners agree.
    """
    if left not in now.images or right not in now.images or left not in before.images:
        return None
    here, there, earlier = (
        _grey(frame.image(camera)) for frame, camera in ((now, left), (now, right), (before, left))
    )
    if not here.shape == there.shape == earlier.shape:
        return None
    corners = _corners(here, ignored)
    if len(corners) < _LEAST_INLIERS:
        return None
    matched, in_pair = _tracked(here, there, corners)
    followed, in_time = _tracked(here, earlier, corners)
    disparity = corners[:, 0] - matched[:, 0]
    good = in_pair & in_time & (np.abs(corners[:, 1] - matched[:, 1]) < _EPIPOLAR)
    good &= disparity > _LEAST_DISPARITY
    calibration = now.calibration
    projection = calibration.projection(left)
    camera, centre = projection[:, :3], calibration.camera_centre(left)
    depth = camera[0, 0] * calibration.baseline(left, right) / disparity[good]
    rays = np.column_stack([corners[good], np.ones(int(good.sum()))]) @ np.linalg.inv(camera).T
    motion = _agreed_motion(rays * depth[:, None], followed[good], camera)
    if motion is None:
        return None
    # From the left camera's own frame to the rectified frame of camera 0, which labels are in.
    motion[:3, 3] += centre - motion[:3, :3] @ centre
    return motion


def _agreed_motion(points: Floats, pixels: Float32s, camera: Floats) -> Floats | None:
    import cv2

    if len(points) < _LEAST_INLIERS:
        return None
    seen = pixels.astype(np.float64)
    found, turn, shift, inliers = cv2.solvePnPRansac(
        points,
        seen,
        camera,
        None,
        iterationsCount=_TRIALS,
        reprojectionError=_REPROJECTION,
        confidence=0.999,
        flags=cv2.SOLVEPNP_EPNP,
    )
    if not found or len(inliers) < max(_LEAST_INLIERS, _LEAST_SHARE * len(points)):
        return None
    agreeing = inliers[:, 0]
    turn, shift = cv2.solvePnPRefineLM(points[agreeing], seen[agreeing], camera, None, turn, shift)
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = cv2.Rodrigues(turn)[0], shift[:, 0]
    return motion if np.isfinite(motion).all() else None


def _corners(image: NDArray[np.uint8], ignored: Floats | None) -> Float32s:
    import cv2

    mask = np.full(image.shape, 255, np.uint8)
    for left, top, right, bottom in np.zeros((0, 4)) if ignored is None else ignored:
        rows = slice(max(int(top), 0), max(int(bottom) + 1, 0))
        mask[rows, max(int(left), 0) : max(int(right) + 1, 0)] = 0
    found = cv2.goodFeaturesToTrack(image, _CORNERS, _QUALITY, _SPACING, mask=mask)
    return np.zeros((0, 2), np.float32) if found is None else np.asarray(found[:, 0], np.float32)


def _tracked(
    first: NDArray[np.uint8], second: NDArray[np.uint8], corners: Float32s
) -> tuple[Float32s, NDArray[np.bool_]]:
    """Where corners are in another image, and whether they are found back from there."""
    import cv2

    settings: Any = {"winSize": (_WINDOW, _WINDOW), "maxLevel": _LEVELS}
    nowhere: Any = None  # Where to begin; OpenCV takes the place itself.
    there, forth, _ = cv2.calcOpticalFlowPyrLK(first, second, corners, nowhere, **settings)
    home, back, _ = cv2.calcOpticalFlowPyrLK(second, first, there, nowhere, **settings)
    round_trip = np.abs(home - corners).max(axis=1)
    return np.asarray(there, np.float32), (forth[:, 0] > 0) & (back[:, 0] > 0) & (
        round_trip < _ROUND_TRIP
    )


def _grey(image: Image) -> NDArray[np.uint8]:
    import cv2

    return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
