"""How often each kind of bogus points is taken for an obstacle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter3.identification.summary import FEWEST
from avsec_gym.experiments.chapter3.objects.believed_points import (
    ATTACKED,
    BELIEVED_OPTIONS,
    CARS,
    CLEAN,
    PLANES,
    TRUTH,
    believed_setting,
    found_setting,
    score_name,
)
from avsec_gym.experiments.chapter3.objects.score_thresholds import ScoreThreshold, score_threshold
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results
from avsec_gym.validation.recordings import drive_of


@dataclass(frozen=True)
class BelievedRow:
    """How often a kind of bogus points is taken for an obstacle.

    Args:
        detector: The detector.
        kind: The kind, one of `PLANES` and `CARS`.
        taken: The share of judged frames in which they are.
        clean: Frames in which there was an obstacle at that place in the clean scan.
        newly: Frames in which there was one in the attacked scan alone.
    """

    detector: str
    kind: str
    taken: Share
    clean: Share
    newly: Share


@dataclass(frozen=True)
class BelievedSummary:
    """Which bogus points detectors believe.

    Args:
        objects: The score of each detector from which on a box is an obstacle, see
            `score_threshold`.
        rows: The shares of each detector and kind.
    """

    objects: Mapping[str, ScoreThreshold]
    rows: Sequence[BelievedRow]


def believed_summary(results: Results, configuration: Configuration) -> BelievedSummary | None:
    """The summary of a run; None with fewer than `FEWEST` frames."""
    options = {**BELIEVED_OPTIONS, **configuration.options}
    detectors = options["believers"].split(",")
    objects = {name: score_threshold(results, TRUTH, found_setting(name)) for name in detectors}
    rows = []
    for detector in detectors:
        for kind in (*PLANES, *CARS):
            attacked, clean = (
                _taken(results, kind, score_name(detector, state), objects[detector].score)
                for state in (ATTACKED, CLEAN)
            )
            if len(attacked) < FEWEST:
                continue
            frames = sorted(attacked)
            drives = [drive_of(id) for id in frames]
            taken, before = (
                np.array([by_frame[id] for id in frames], bool) for by_frame in (attacked, clean)
            )
            rows.append(
                BelievedRow(
                    detector,
                    kind,
                    taken=share_of(taken, drives),
                    clean=share_of(before, drives),
                    newly=share_of(taken & ~before, drives),
                )
            )
    return BelievedSummary(objects, rows) if rows else None


def _taken(results: Results, kind: str, name: str, score: float) -> dict[str, bool]:
    """By frame; no score, NaN, is stored where there is no box."""
    rows = results.measurements(setting=believed_setting(kind), name=name)
    return {row.scenario: row.value >= score for row in rows}
