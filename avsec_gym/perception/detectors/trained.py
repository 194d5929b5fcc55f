"""The stereo detectors with weights: those of the package, or a file of the user's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from avsec_gym.perception.weights.packaged import weights_file
from avsec_gym.perception.weights.store import load_weights


def trained_dsgn(configuration: str = "small", weights: str | Path | None = None) -> Any:
    """DSGN, ready to detect.

    Args:
        configuration: A preset.
        weights: A file as `avsec train` and `avsec weights import` write it; the package's if None.

    Raises:
        ConfigurationError: No such preset.
        DataError: There are no such weights, or they are of another network.
    """
    from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector

    detector = DsgnDetector(configuration)
    load_weights(weights_file("dsgn", configuration, weights), detector.network)
    return detector


def trained_stereo_rcnn(configuration: str = "small", weights: str | Path | None = None) -> Any:
    """Stereo R-CNN, ready to detect; see `trained_dsgn`."""
    from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector

    detector = StereoRcnnDetector(configuration)
    load_weights(weights_file("stereo_rcnn", configuration, weights), detector.network)
    return detector
