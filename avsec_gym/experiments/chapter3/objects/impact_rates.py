"""What optical attacks do to undefended detectors (thesis, section 3.2.4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from avsec_gym.experiments.chapter3.identification.summary import FEWEST
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import taken_for_an_obstacle
from avsec_gym.experiments.chapter3.objects.car_precision import car_precision, precision_rows
from avsec_gym.experiments.chapter3.objects.score_thresholds import score_thresholds
from avsec_gym.experiments.chapter3.objects.sensor_detections import (
    DETECTION_OPTIONS,
    PATCH,
    seen_setting,
    truth_setting,
)
from avsec_gym.experiments.chapter3.recordings import JUDGED, SYSTEM
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.recordings import drive_of

IOU = 0.5
"""That the thesis asks for here."""
SCORES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
"""That make a box an obstacle: how much hangs on it."""


def impact_summary(results: Results, configuration: Configuration) -> dict[str, Any] | None:
    """Both figures of a run; None with fewer than `FEWEST` frames.

    Returns:
        ``lidar``: from which ``score`` on a box is an obstacle; in how many frames the bogus
        return was ``taken`` for one, in how many the ``clean`` scan has one at that place, and in
        how many only the attacked one (``newly``); and ``by_score`` the same for `SCORES`.
        ``camera``: average precision of cars in the reference's image, ``clean`` and ``attacked``
        (`precision_rows`); None without labels.
    """
    options = {**DETECTION_OPTIONS, **configuration.options}
    lidar = _bogus_returns(results, options)
    if lidar is None or lidar["taken"]["of"] < FEWEST:
        return None
    return {
        "lidar": {"detector": options["lidar_detector"], **lidar},
        "camera": _facula(results, options["image_detector"]),
    }


def _bogus_returns(results: Results, options: dict[str, Any]) -> dict[str, Any] | None:
    patches = results.detections(PATCH)
    if not patches:
        return None
    frames = sorted(patches)
    drives = [drive_of(id) for id in frames]
    found = {
        name: results.detections(seen_setting(JUDGED, LIDAR, attacked, SYSTEM.reference))
        for name, attacked in (("clean", False), ("taken", True))
    }

    def shares(score: float) -> dict[str, Any]:
        hits = {
            name: np.array(
                [
                    taken_for_an_obstacle(own[id][own[id].score >= score], patches[id])
                    for id in frames
                ],
                bool,
            )
            for name, own in found.items()
        }
        newly = share_of(hits["taken"] & ~hits["clean"], drives)
        return {
            "score": score,
            **{name: share_of(hit, drives) for name, hit in hits.items()},
            "newly": newly,
        }

    own = score_thresholds(results, options)["lidar"]["score"]
    return {**shares(own), "by_score": [shares(score) for score in SCORES]}


def _facula(results: Results, detector: str) -> dict[str, Any] | None:
    truth = results.detections(truth_setting(JUDGED))
    clean, attacked = (
        results.detections(seen_setting(JUDGED, SYSTEM.reference, state, SYSTEM.reference))
        for state in (False, True)
    )
    frames = sorted(truth.keys() & clean.keys() & attacked.keys())
    if len(frames) < FEWEST:
        return None
    before, after = (car_precision(truth, found, frames, "2d", IOU) for found in (clean, attacked))
    return {
        "detector": detector,
        "frames": len(frames),
        "iou": IOU,
        "clean": precision_rows(before, before),
        "attacked": precision_rows(before, after),
    }
