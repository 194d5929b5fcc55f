"""A LiDAR scan as the network sees it: points in view, in the camera frame, always as many."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.frame import Points, SensorFrame
from avsec_gym.geometry import Floats, project, transform_points
from avsec_gym.perception.detectors.pointrcnn.configuration import PointView

_HALF_VIEW = np.radians(40.0)
"""Of KITTI's camera, to either side, for frames without its image."""


def points_in_view(frame: SensorFrame, view: PointView) -> NDArray[np.float32]:
    """The points of a frame that the network may see.

    Args:
        frame: With a scan; where there is image 2, only what it shows is in view.
        view: The region.

    Returns:
        Shape (M, 3), camera frame.

    Raises:
        DataError: The frame has no scan, or no point in view.
    """
    places = _in_camera_frame(frame.points, frame)
    inside = np.ones(len(places), bool)
    ranges = (view.side, view.down, view.forward)
    for values, (start, stop) in zip(places.T, ranges, strict=True):
        inside &= (values >= start) & (values <= stop)
    places = places[inside]
    places = places[_shown(places, frame)]
    if not len(places):
        raise DataError(
            f"No point of the LiDAR scan of frame {frame.id} is in view.",
            path=frame.origin,
            remedy="Without returns nothing can be said of what is there.",
        )
    return places.astype(np.float32)


def sampled_points(
    places: NDArray[np.float32], view: PointView, randomness: np.random.Generator
) -> NDArray[np.float32]:
    """As many points as the network takes, in random order.

    Args:
        places: Shape (M, 3), M at least 1; where there are too few, some come repeatedly.
        view: How many, and which are preferred.
        randomness: Draws.

    Returns:
        Shape (points, 3).
    """
    count = view.points
    if len(places) <= count:
        again = randomness.choice(len(places), count - len(places))
        chosen = np.concatenate([np.arange(len(places)), again])
    else:
        is_far = places[:, 2] >= view.far
        far, near = np.flatnonzero(is_far), np.flatnonzero(~is_far)
        most = max(int(view.most_far * count), count - len(near))
        far = randomness.permutation(far)[:most]
        chosen = np.concatenate([far, randomness.permutation(near)[: count - len(far)]])
    return places[randomness.permutation(chosen)]


def _in_camera_frame(points: Points, frame: SensorFrame) -> Floats:
    places = transform_points(frame.calibration.velodyne_to_camera, points[:, :3])
    return places[np.isfinite(places).all(axis=1)]


def _shown(places: Floats, frame: SensorFrame) -> NDArray[np.bool_]:
    if 2 not in frame.images or 2 not in frame.calibration.cameras:
        return np.abs(np.arctan2(places[:, 0], places[:, 2])) < _HALF_VIEW
    height, width = frame.image(2).shape[:2]
    pixels, depth = project(frame.calibration.projection(2), places)
    return (depth > 0) & ((pixels >= 0) & (pixels < [width, height])).all(axis=1)
