"""How often each kind of bogus points is taken for an obstacle."""

from __future__ import annotations

from typing import Any

import numpy as np

from avsec_gym.experiments.chapter3.objects.believed_points import (
    ALREADY,
    ATTACKED,
    BELIEVED_OPTIONS,
    CARS,
    PLANES,
    TRUTH,
    believed_setting,
    found_setting,
    score_name,
)
from avsec_gym.experiments.chapter3.objects.score_thresholds import USUAL
from avsec_gym.experiments.chapter3.shares import drive_of, share_of
from avsec_gym.experiments.chapter3.summary import FEWEST
from avsec_gym.experiments.experiment import Configuration
from avsec_gym.experiments.results import Results
from avsec_gym.metrics.working_point import FROM_ABOVE, working_point


def believed_summary(results: Results, configuration: Configuration) -> list[dict[str, Any]] | None:
    """Of a run; None with fewer than `FEWEST` moments.

    Returns:
        Rows with ``detector`` and ``kind``; ``score``, from which on a box is an obstacle, where
        the detector finds most for its false alarms on the fitted moments; in how many judged ones
        the bogus points were ``taken`` for one, in how many there was one at that place ``clean``,
        and in how many only in the attacked scan, ``newly``.
    """
    options = {**BELIEVED_OPTIONS, **configuration.options}
    rows = []
    for detector in options["believers"].split(","):
        score = _score(results, detector)
        for kind in (*PLANES, *CARS):
            attacked, clean = (
                {row["scenario"]: row["value"] >= score for row in found}
                for found in (
                    results.measurements(
                        setting=believed_setting(kind), name=score_name(detector, state)
                    )
                    for state in (ATTACKED, ALREADY)
                )
            )
            if len(attacked) < FEWEST:
                return None
            moments = sorted(attacked)
            drives = [drive_of(id) for id in moments]
            taken, before = (
                np.array([one[id] for id in moments], bool) for one in (attacked, clean)
            )
            rows.append(
                {
                    "detector": detector,
                    "kind": kind,
                    "score": score,
                    "taken": share_of(taken, drives),
                    "clean": share_of(before, drives),
                    "newly": share_of(taken & ~before, drives),
                }
            )
    return rows


def _score(results: Results, detector: str) -> float:
    truth = results.detections(TRUTH)
    found = results.detections(found_setting(detector))
    moments = sorted(truth.keys() & found.keys())
    if not moments:
        return USUAL
    point = working_point([truth[id] for id in moments], [found[id] for id in moments], FROM_ABOVE)
    return USUAL if point is None else point.score
