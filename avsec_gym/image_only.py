"""Objects that are known in the image only: 2D boxes, without a place in space.

Detectors of single images give them.  KITTI's result files put them at -1000 m with sizes of -1;
they can be scored in the image, and no car can drive by them: planned on, all of them would be a
free road.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats

NOWHERE = -1000.0
"""KITTI's location of an object whose place in space is unknown, x, y and z."""
UNKNOWN_ANGLE = -10.0
"""KITTI's alpha and rotation_y of such an object."""
UNKNOWN_SIZE = 0.01
"""Boxes have positive sizes; this is as little of one as can be."""

WHAT_IT_IS_FOR = "`avsec ap` scores 2D boxes in the image"


def is_image_only(boxes: Boxes3D) -> NDArray[np.bool_]:
    """Which boxes have no place in space, shape (N,).

    Example:
        >>> from avsec_gym.perception.detectors.image_detector import image_boxes
        >>> is_image_only(image_boxes(np.array([[10.0, 20, 60, 50]]), np.ones(1), ["Car"])).tolist()
        [True]
    """
    return np.asarray((boxes.location == NOWHERE).all(axis=1))


def image_only_rows(dimensions: Floats, location: Floats) -> NDArray[np.bool_]:
    """Which rows of a result file hold a 2D box alone, shape (N,).

    Args:
        dimensions: Dimensions as written, shape (N, 3): all -1 in KITTI's files, all 0 in some
            converters'.
        location: Locations as written, shape (N, 3): -1000 in KITTI's files.
    """
    sizeless = (dimensions == -1).all(axis=1) | (dimensions == 0).all(axis=1)
    return np.asarray(sizeless | (location == NOWHERE).all(axis=1))


def check_places(boxes: Boxes3D) -> None:
    """Boxes that a car is to drive by have to stand in space.

    Raises:
        ConfigurationError: One is known in the image only.
    """
    lost = int(is_image_only(boxes).sum())
    if lost:
        raise ConfigurationError(
            f"{lost} of {len(boxes)} boxes are known in the image only, as detectors of single"
            " images (faster_rcnn, yolo) find them: no car can drive by them, it would take the"
            f" road for free.  Use a detector of 3D boxes; {WHAT_IT_IS_FOR}"
        )


def check_detector(detector: Any) -> None:
    """Check that a detector finds where things are, as a car needs that is to drive by it.

    Args:
        detector: The detector; one whose boxes are known in the image only has ``image_only =
            True``.

    Raises:
        ConfigurationError: It finds 2D boxes alone.
    """
    if getattr(detector, "image_only", False):
        raise ConfigurationError(
            f"the detector {detector.name!r} finds 2D boxes in one image: no car can drive by them,"
            " it would take the road for free.  Use one of 3D boxes, such as dsgn, stereo_rcnn,"
            f" pixor or pointrcnn; {WHAT_IT_IS_FOR}"
        )
