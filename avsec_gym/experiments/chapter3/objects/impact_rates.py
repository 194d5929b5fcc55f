"""What optical attacks do to undefended detectors (thesis, section 3.2.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from avsec_gym.experiments.chapter3.identification.summary import FEWEST
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import taken_for_an_obstacle
from avsec_gym.experiments.chapter3.objects.car_precision import (
    PrecisionAtLevel,
    car_precision,
    precision_rows,
)
from avsec_gym.experiments.chapter3.objects.score_thresholds import score_thresholds
from avsec_gym.experiments.chapter3.objects.sensor_detections import (
    DETECTION_OPTIONS,
    PATCH,
    seen_setting,
    truth_setting,
)
from avsec_gym.experiments.chapter3.recordings import JUDGED, SYSTEM
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.recordings import drive_of

IOU = 0.5
"""The overlap that the thesis asks for here."""
SCORES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
"""Scores that make a box an obstacle: how much hangs on it."""


@dataclass(frozen=True)
class BogusReturnShares:
    """How often the bogus return is taken for an obstacle.

    Args:
        score: The score from which on a box is one.
        clean: Frames with one at that place in the clean scan.
        taken: Frames with one there in the attacked scan.
        newly: Frames with one there in the attacked scan alone.
    """

    score: float
    clean: Share
    taken: Share
    newly: Share


@dataclass(frozen=True)
class BogusReturnImpact:
    """What bogus returns do to a detector.

    Args:
        detector: The detector.
        shares: Shares by the score of `score_thresholds`.
        by_score: Shares by each of `SCORES`.
    """

    detector: str
    shares: BogusReturnShares = field(metadata=FLAT)
    by_score: Sequence[BogusReturnShares]


@dataclass(frozen=True)
class FaculaImpact:
    """What a facula costs a detector of cars in the reference's image.

    Args:
        detector: The detector.
        frames: The number of frames.
        iou: The IoU that a match exceeds.
        clean: Average precision without the attack, by level.
        attacked: The same under it.
    """

    detector: str
    frames: int
    iou: float
    clean: Mapping[str, PrecisionAtLevel]
    attacked: Mapping[str, PrecisionAtLevel]


@dataclass(frozen=True)
class ImpactSummary:
    """What optical attacks do to undefended detectors.

    Args:
        lidar: The impact of bogus returns.
        camera: The impact of faculae; None without labels.
    """

    lidar: BogusReturnImpact
    camera: FaculaImpact | None


def impact_summary(results: Results, configuration: Configuration) -> ImpactSummary | None:
    """Both figures of a run; None with fewer than `FEWEST` frames."""
    options = {**DETECTION_OPTIONS, **configuration.options}
    lidar = _bogus_returns(results, options)
    if lidar is None or lidar.shares.taken.of < FEWEST:
        return None
    return ImpactSummary(lidar, _facula(results, options["image_detector"]))


def _bogus_returns(results: Results, options: dict[str, Any]) -> BogusReturnImpact | None:
    patches = results.detections(PATCH)
    if not patches:
        return None
    frames = sorted(patches)
    drives = [drive_of(id) for id in frames]
    found = {
        name: results.detections(seen_setting(JUDGED, LIDAR, attacked, SYSTEM.reference))
        for name, attacked in (("clean", False), ("taken", True))
    }

    def shares(score: float) -> BogusReturnShares:
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
        return BogusReturnShares(
            score, share_of(hits["clean"], drives), share_of(hits["taken"], drives), newly
        )

    own = score_thresholds(results, options)["lidar"].score
    by_score = [shares(score) for score in SCORES]
    return BogusReturnImpact(options["lidar_detector"], shares(own), by_score)


def _facula(results: Results, detector: str) -> FaculaImpact | None:
    truth = results.detections(truth_setting(JUDGED))
    clean, attacked = (
        results.detections(seen_setting(JUDGED, SYSTEM.reference, state, SYSTEM.reference))
        for state in (False, True)
    )
    frames = sorted(truth.keys() & clean.keys() & attacked.keys())
    if len(frames) < FEWEST:
        return None
    before, after = (car_precision(truth, found, frames, "2d", IOU) for found in (clean, attacked))
    return FaculaImpact(
        detector,
        len(frames),
        IOU,
        clean=precision_rows(before, before),
        attacked=precision_rows(before, after),
    )
