"""How often each kind of bogus points is taken for an obstacle."""

from __future__ import annotations

from typing import Any

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
from avsec_gym.experiments.chapter3.objects.score_thresholds import score_threshold
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results
from avsec_gym.validation.recordings import drive_of


def believed_summary(results: Results, configuration: Configuration) -> dict[str, Any] | None:
    """Of a run; None with fewer than `FEWEST` frames.

    Returns:
        ``objects``: of each detector from which ``score`` on a box is an obstacle, see
        `score_threshold`; ``rows`` with ``detector`` and ``kind``, in how many judged frames the
        bogus points were ``taken`` for one, in how many there was one at that place ``clean``, and
        in how many only in the attacked scan, ``newly``.
    """
    options = {**BELIEVED_OPTIONS, **configuration.options}
    detectors = options["believers"].split(",")
    objects = {name: score_threshold(results, TRUTH, found_setting(name)) for name in detectors}
    rows = []
    for detector in detectors:
        for kind in (*PLANES, *CARS):
            attacked, clean = (
                _taken(results, kind, score_name(detector, state), objects[detector]["score"])
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
                {
                    "detector": detector,
                    "kind": kind,
                    "taken": share_of(taken, drives),
                    "clean": share_of(before, drives),
                    "newly": share_of(taken & ~before, drives),
                }
            )
    return {"objects": objects, "rows": rows} if rows else None


def _taken(results: Results, kind: str, name: str, score: float) -> dict[str, bool]:
    """By frame; None is stored where there is no box."""
    rows = results.measurements(setting=believed_setting(kind), name=name)
    return {row["scenario"]: row["value"] is not None and row["value"] >= score for row in rows}
