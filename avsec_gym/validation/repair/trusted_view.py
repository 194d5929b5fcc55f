"""`TrustedView`: what a camera should see, by the sensors that are trusted."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import permutations

import cv2
import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, Image, SensorFrame
from avsec_gym.perception.depth.lidar import visible_points
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.validation.evidence.brightness import is_grey
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.reprojection import Depth, Mask, carried_depth, carried_image

_FARTHEST = 500.0
"""Metres; to the cameras of a car all that is farther looks the same."""
_GAP = 8
"""Pixels between two points of a scan, and more."""


@dataclass(frozen=True, eq=False)
class TrustedView:
    """A camera's view without that camera.

    Args:
        known: Depths that were measured, shape (H, W), metres, NaN elsewhere.
        depth: The same with all gaps filled, by what is farther away at their ends.
        image: Painted with the images of trusted cameras, shape (H, W, 3).
        believed: Where some trusted camera sees what was painted, shape (H, W).
    """

    known: Depth
    depth: Depth
    image: Image
    believed: Mask


def trusted_view(
    frame: SensorFrame, camera: int, trusted: Iterable[Sensor], depth: PairDepth | None = None
) -> TrustedView:
    """What a camera should see.

    Args:
        frame: The frame.
        camera: Which one; its own image is not looked at, but for its size and whether it is grey.
        trusted: A camera or more, and what gives depth: a second one, or a LiDAR.
        depth: How the disparities of two trusted cameras are found.

    Raises:
        ConfigurationError: No trusted camera, no trusted depth, or the camera trusts itself.
        DataError: The frame lacks a sensor, or its file is broken.
    """
    sensors = tuple(trusted)
    if camera in sensors:
        raise ConfigurationError(f"camera {camera} is not to be checked by itself")
    sources = _sources(frame, camera, sensors)
    known = trusted_depth(frame, camera, sensors, depth)
    if not sources or not np.isfinite(known).any():
        raise ConfigurationError(
            f"to see in place of camera {camera} takes a trusted camera, and a second one or the "
            f"LiDAR for depth; trusted are: {', '.join(map(str, sensors)) or 'none'}"
        )
    filled = filled_depth(known)
    image = np.zeros((*known.shape, 3), np.uint8)
    believed = np.zeros(known.shape, bool)
    for source in reversed(sources):
        painted, seen = carried_image(
            frame.image(source), filled, frame.calibration, source, camera
        )
        # The first source also paints what no source sees, so that nothing is black.
        image = np.where((seen | (source == sources[0]) & ~believed)[..., None], painted, image)
        believed |= seen
    return TrustedView(known, filled, image, believed)


def trusted_depth(
    frame: SensorFrame, camera: int, trusted: Iterable[Sensor], depth: PairDepth | None = None
) -> Depth:
    """Depths in a camera's view: of the widest trusted pair, in its holes of the LiDAR.

    Args:
        frame: The frame.
        camera: The camera whose view it is.
        trusted: The trusted sensors.
        depth: How disparities of two cameras are found.

    Returns:
        Shape (H, W), metres, NaN where unknown; all of it if no trusted sensor gives depth.
    """
    sensors, calibration = tuple(trusted), frame.calibration
    shape = frame.image(camera).shape[:2]
    result = np.full(shape, np.nan, np.float32)
    pair = widest_pair(calibration, sensors)
    if pair is not None:
        left, right = pair
        found = (depth or PairDepth()).estimator(calibration, left, right).disparity(frame).depth
        found = np.minimum(found, np.float32(_FARTHEST))
        result = found if left == camera else carried_depth(found, calibration, left, camera)
    if LIDAR in sensors:
        uv, ahead, _ = visible_points(frame.points, calibration, shape, camera)
        column, row = np.round(uv).astype(np.int64).T
        hole = np.isnan(result[row, column])
        result[row[hole], column[hole]] = ahead[hole]
    return result


def widest_pair(calibration: Calibration, trusted: Iterable[Sensor]) -> tuple[int, int] | None:
    """The trusted cameras, left and right, that stand farthest apart; None with fewer than two."""
    cameras = [sensor for sensor in trusted if isinstance(sensor, int)]
    return max(permutations(cameras, 2), key=lambda pair: calibration.baseline(*pair), default=None)


def filled_depth(depth: Depth) -> Depth:
    """Depths with all gaps filled.

    Small gaps, such as those between a scan's points, take the nearest known pixel's depth; wider
    ones that of the farther end in their row, since it is the background that sensors beside each
    other see differently; rows without any depth, the nearest pixel's again.

    Args:
        depth: Depth with at least one pixel known.
    """
    known = np.isfinite(depth)
    distance, label = cv2.distanceTransformWithLabels(
        np.asarray(~known, np.uint8),
        cv2.DIST_L2,
        cv2.DIST_MASK_5,
        labelType=cv2.DIST_LABEL_PIXEL,
    )
    by_label = np.zeros(int(label.max()) + 1, np.float32)
    by_label[label[known]] = depth[known]
    nearest = by_label[label]
    close = np.where(distance <= _GAP, nearest, np.float32(np.nan))
    farther = np.fmax(_last_known(close), _last_known(close[:, ::-1])[:, ::-1])
    result = np.where(np.isnan(close), farther, close)
    return np.where(np.isnan(result), nearest, result)


def _sources(frame: SensorFrame, camera: int, trusted: tuple[Sensor, ...]) -> list[int]:
    """Trusted cameras: first those that see colours, or none, as this one does; the nearest."""
    calibration, grey = frame.calibration, is_grey(frame.image(camera))
    return sorted(
        (sensor for sensor in trusted if isinstance(sensor, int)),
        key=lambda source: (
            is_grey(frame.image(source)) != grey,
            abs(calibration.baseline(camera, source)),
        ),
    )


def _last_known(depth: Depth) -> Depth:
    """At each pixel the last depth known to its left in its row, its own included; else NaN."""
    columns = np.where(np.isfinite(depth), np.arange(depth.shape[1]), 0)
    return np.take_along_axis(depth, np.maximum.accumulate(columns, axis=1), axis=1)
