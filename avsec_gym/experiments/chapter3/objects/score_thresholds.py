"""From which score on a box counts as an object.

Scores of two networks mean different things, and what the best threshold is no attack may tell: it
is each detector's working point on clean moments that nothing is judged on.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.experiments.chapter3.objects.sensor_detections import (
    DETECTION_OPTIONS,
    seen_setting,
    truth_setting,
)
from avsec_gym.experiments.chapter3.recordings import FITTED, SYSTEM
from avsec_gym.experiments.results import Results
from avsec_gym.metrics.working_point import FROM_ABOVE, IN_IMAGE, working_point
from avsec_gym.sensor_system import LIDAR, Sensor

USUAL = 0.3
"""Where nobody labelled the clean moments."""


def score_thresholds(results: Results, options: Mapping[str, Any]) -> dict[str, Any]:
    """Of the LiDAR's detector, ``lidar``, and of the images', ``camera``.

    Args:
        results: Of a run.
        options: `DETECTION_OPTIONS`, as far as a user chose them.

    Returns:
        For each ``score``; and its ``precision`` and ``recall`` on the fitted moments (cars,
        moderate, IoU 0.5 from above or in the image), None where they are not known.
    """
    given = {**DETECTION_OPTIONS, **options}["score_threshold"]
    reference = SYSTEM.reference
    return {
        "lidar": _threshold(results, given, LIDAR, FROM_ABOVE),
        "camera": _threshold(results, given, reference, IN_IMAGE),
    }


def _threshold(results: Results, given: float, sensor: Sensor, seen: int) -> dict[str, Any]:
    if given > 0:
        return {"score": given, "precision": None, "recall": None}
    truth = results.detections(truth_setting(FITTED))
    found = results.detections(seen_setting(FITTED, sensor, False, SYSTEM.reference))
    moments = sorted(truth.keys() & found.keys())
    point = None
    if moments:
        point = working_point([truth[id] for id in moments], [found[id] for id in moments], seen)
    if point is None:
        return {"score": USUAL, "precision": None, "recall": None}
    return point._asdict()
