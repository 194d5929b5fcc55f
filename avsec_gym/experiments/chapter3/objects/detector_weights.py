"""The detectors of chapter 3 by name, with the weights that a run's options name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors import Detector, ImageDetector
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.perception.weights.store import card_path
from avsec_gym.registry import Kind, make

WEIGHT_OPTIONS = {"pixor": "", "pointrcnn": "", "faster_rcnn": "", "yolo": ""}
"""The weights by the networks' names, instead of those of the package."""


def lidar_detector(name: str, options: Mapping[str, Any]) -> Detector:
    """A detector that looks at scans.

    Args:
        name: ``pixor``, ``pointrcnn``, or one that a plug-in registered, which has its own weights.
        options: Options with the weights, see `WEIGHT_OPTIONS`.
    """
    detector: Detector = make(Kind.DETECTOR, _with_weights(name, options))
    return detector


def scan_alone(frame: SensorFrame) -> SensorFrame:
    """A frame without images: what a detector of scans looks at."""
    return SensorFrame(frame.id, frame.calibration, scan=frame.points, origin=frame.origin)


def image_detector(name: str, options: Mapping[str, Any]) -> ImageDetector:
    """The same of single images: ``faster_rcnn``, ``yolo``, or a plug-in's."""
    detector: ImageDetector = make(Kind.IMAGE_DETECTOR, _with_weights(name, options))
    return detector


def weights_of(name: str, options: Mapping[str, Any]) -> Path:
    """Where a network's weights are: those that are named, or the package's."""
    return Path(options[name]) if options.get(name) else shipped_weights(f"{name}_small")


def weight_inputs(names: Iterable[str], options: Mapping[str, Any]) -> dict[str, Path]:
    """Files of weights, and their cards, which hold calibrations.

    Args:
        names: The names of networks; those that no option gives weights to are left out.
        options: The options of the run, among them the weights by the networks' names.
    """
    found = {}
    for name in (network for network in names if network in options):
        found[f"weights of {name}"] = weights = weights_of(name, options)
        if (card := card_path(weights)).is_file():
            found[f"card of {name}"] = card
    return found


def _with_weights(name: str, options: Mapping[str, Any]) -> dict[str, Any]:
    own = {"weights": weights_of(name, options)} if name in WEIGHT_OPTIONS else {}
    return {"name": name, **own}
