"""Stereo 3D detectors, b = O(I_l, I_r), and detectors of boxes in single images."""

from __future__ import annotations

from typing import Any

from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.perception.detectors.image_detector import ImageDetector
from avsec_gym.registry import Kind, make


def make_detector(what: Any) -> Detector:
    """The detector that a name, a dictionary or an object stands for.

    Args:
        what: ``dsgn``, ``stereo_rcnn``, ``oracle``, or another registered name; a dictionary such
            as ``{"name": "replayed", "detections": DIR}``; or a live detector.

    Raises:
        ConfigurationError: Nothing has that name, or the arguments do not fit.
        DataError: Its files are missing.

    Example:
        >>> make_detector("oracle").name
        'oracle'
    """
    detector: Detector = make(Kind.DETECTOR, what)
    return detector


def make_image_detector(what: Any) -> ImageDetector:
    """The detector of single images that a name, a dictionary or an object stands for.

    Args:
        what: ``faster_rcnn`` or ``yolo``, or a name that a plug-in registered; a dictionary such as
            ``{"name": "yolo", "weights": FILE}``; or a live detector.

    Raises:
        ConfigurationError: Nothing has that name, or the arguments do not fit.
        DataError: Its files are missing.
    """
    detector: ImageDetector = make(Kind.IMAGE_DETECTOR, what)
    return detector


__all__ = ["Detector", "ImageDetector", "make_detector", "make_image_detector"]
