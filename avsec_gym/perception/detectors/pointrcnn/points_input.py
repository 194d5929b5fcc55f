"""A LiDAR scan as the network sees it: points in view, in the camera frame, always as many."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.frame import Points, SensorFrame
from avsec_gym.geometry import Floats, project, transform_points
from avsec_gym.perception.detectors.pointrcnn.configuration import PointView

_HALF_VIEW = np.radians(40.0)
"""Half the view of KITTI's camera, to either side, for frames without its image."""


def points_in_view(frame: SensorFrame, view: PointView) -> NDArray[np.float32]:
    """The points of a frame that the network may see.

    Args:
        frame: The frame with its scan; where there is image 2, only what it shows is in view.
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
    places: NDArray[np.float32], view: PointView, randomness: np.random.Generator | None = None
) -> NDArray[np.float32]:
    """The number of points that the network takes, in random order.

    Args:
        places: The places, shape (M, 3), M at least 1; where there are too few, some come
            repeatedly.
        view: How many, and which are preferred.
        randomness: The generator that draws the points.  None: chance lies in the points
            themselves, so that the same ones are taken of the same scan in whatever order, and more
            points push out only as many.

    Returns:
        Shape (points, 3).
    """
    count = view.points
    chance = _chance(places) if randomness is None else randomness.random(len(places))
    order = np.argsort(chance, kind="stable")
    if len(places) > count:
        is_far = places[order, 2] >= view.far
        far, near = order[is_far], order[~is_far]
        far = far[: max(int(view.most_far * count), count - len(near))]
        order = np.concatenate([far, near[: count - len(far)]])
        order = order[np.argsort(chance[order], kind="stable")]
    return places[np.resize(order, count)]


def _chance(places: NDArray[np.float32]) -> NDArray[np.uint64]:
    """A number of each point that its coordinates decide, as if drawn, shape (M,)."""
    words = np.ascontiguousarray(places, np.float32).view(np.uint32).astype(np.uint64)
    mixed = np.zeros(len(places), np.uint64)
    for word in words.T:
        # The finaliser of splitmix64 (Steele et al., 2014), word by word.
        mixed = (mixed ^ word) + np.uint64(0x9E3779B97F4A7C15)
        mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        mixed ^= mixed >> np.uint64(31)
    return mixed


def _in_camera_frame(points: Points, frame: SensorFrame) -> Floats:
    places = transform_points(frame.calibration.velodyne_to_camera, points[:, :3])
    return places[np.isfinite(places).all(axis=1)]


def _shown(places: Floats, frame: SensorFrame) -> NDArray[np.bool_]:
    if 2 not in frame.images or 2 not in frame.calibration.cameras:
        return np.abs(np.arctan2(places[:, 0], places[:, 2])) < _HALF_VIEW
    height, width = frame.image(2).shape[:2]
    pixels, depth = project(frame.calibration.projection(2), places)
    return (depth > 0) & ((pixels >= 0) & (pixels < [width, height])).all(axis=1)
