"""From which score on a box counts as an object.

Scores of two networks mean different things, and no attack may influence the threshold: it is each
detector's working point on clean frames that nothing is judged on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from avsec_gym.experiments.chapter3.objects.sensor_detections import (
    DETECTION_OPTIONS,
    seen_setting,
    truth_setting,
)
from avsec_gym.experiments.chapter3.recordings import FITTED, SYSTEM
from avsec_gym.metrics.working_point import FROM_ABOVE, IN_IMAGE, working_point
from avsec_gym.runs.results import Results
from avsec_gym.sensor_system import LIDAR, Sensor

USUAL = 0.3
"""The threshold where the clean frames have no labels."""


@dataclass(frozen=True)
class ScoreThreshold:
    """The score from which on a box counts as an object.

    Args:
        score: The score.
        precision: Precision on the fitted frames (cars, moderate, IoU 0.5 from above or in the
            image); None: not known.
        recall: Recall on the fitted frames; None: not known.
    """

    score: float
    precision: float | None = None
    recall: float | None = None


def score_thresholds(results: Results, options: Mapping[str, Any]) -> dict[str, ScoreThreshold]:
    """The thresholds of the LiDAR's detector, ``lidar``, and of the images', ``camera``.

    Args:
        results: The results of a run.
        options: `DETECTION_OPTIONS`, as far as a user chose them.
    """
    given = {**DETECTION_OPTIONS, **options}["score_threshold"]
    if given > 0:
        return {name: ScoreThreshold(given) for name in ("lidar", "camera")}
    camera, truth = SYSTEM.reference, truth_setting(FITTED)
    places: dict[str, tuple[Sensor, int]] = {
        "lidar": (LIDAR, FROM_ABOVE),
        "camera": (camera, IN_IMAGE),
    }
    return {
        name: score_threshold(results, truth, seen_setting(FITTED, sensor, False, camera), seen)
        for name, (sensor, seen) in places.items()
    }


def score_threshold(
    results: Results, truth_of: str, found_of: str, seen: int = FROM_ABOVE
) -> ScoreThreshold:
    """The threshold of one detector, from clean frames.

    Args:
        results: The results of a run.
        truth_of: The setting of labels.
        found_of: The setting of detections.
        seen: `FROM_ABOVE` or `IN_IMAGE`.
    """
    truth, found = results.detections(truth_of), results.detections(found_of)
    frames = sorted(truth.keys() & found.keys())
    point = None
    if frames:
        point = working_point([truth[id] for id in frames], [found[id] for id in frames], seen)
    if point is None:
        return ScoreThreshold(USUAL)
    return ScoreThreshold(point.score, point.precision, point.recall)
