"""How well damage is located and repaired, attack by attack, as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from avsec_gym.experiments.chapter3.localisation.measures import CAR, attacks_of
from avsec_gym.experiments.chapter3.localisation.repaired_moments import LOCALISATION_OPTIONS
from avsec_gym.experiments.chapter3.recordings import SYSTEM
from avsec_gym.experiments.chapter3.shares import drive_of
from avsec_gym.experiments.chapter5.decoupling import Sampled
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES
from avsec_gym.metrics.average_precision_curves import draw_resamples
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results

BOGUS_SEEN = ("bogus_clean", "bogus_before", "bogus_after")
"""Whether a detector of scans sees an obstacle where bogus points are, in three scans."""
MEANS = ("precision", "recall", "iou_of_lost", "error_before", "error_after", *BOGUS_SEEN)
SUMS = ("objects", "found_before", "found_cleaned", "found_after")
"""Measures of `measures_of`, and counts of objects."""
LOWEST, MEDIAN = "lowest", "median"
"""Moments that are told one by one, by their IoU."""


def localisation_summary(results: Results, configuration: Configuration) -> dict[str, Any] | None:
    """Means over the moments; None without any.

    Returns:
        ``detector`` and ``scan_detector``, empty without one, from which scores on their boxes
        count (``score_threshold``, ``scan_score_threshold``), and ``attacks``: of each its name as
        ``attack``; ``moments``; the mean ``iou`` with its ``interval``, 95 %, bootstrap over
        drives, None of a single one; `LOWEST` and `MEDIAN`, each an ``iou`` and its ``moment``;
        means (`MEANS`) and sums (`SUMS`), None where nothing was measured.
    """
    rows = []
    for attack in (*attacks_of(SYSTEM.reference), CAR):
        found: dict[str, dict[str, float | None]] = {}
        for row in results.measurements(setting=attack):
            found.setdefault(row["name"], {})[row["scenario"]] = row["value"]
        if found:
            rows.append({"attack": attack, **_row(found)})
    options = {**LOCALISATION_OPTIONS, **configuration.options}
    names = ("detector", "score_threshold", "scan_detector", "scan_score_threshold")
    detectors = {name: options[name] for name in names}
    return {**detectors, "attacks": rows} if rows else None


def _row(found: Mapping[str, Mapping[str, float | None]]) -> dict[str, Any]:
    """Of one attack.

    Args:
        found: Values by name and moment.
    """
    known = {
        name: {moment: value for moment, value in values.items() if value is not None}
        for name, values in found.items()
    }
    iou = known["iou"]
    order = sorted(iou, key=lambda moment: (iou[moment], moment))
    told = {LOWEST: order[0], MEDIAN: order[(len(order) - 1) // 2]} if order else {}
    return {
        "moments": len(found["iou"]),
        "iou": _mean(iou),
        "interval": _interval(iou),
        **dict.fromkeys((LOWEST, MEDIAN)),
        **{which: {"moment": one, "iou": iou[one]} for which, one in told.items()},
        **{name: _mean(known.get(name, {})) for name in MEANS},
        **{name: int(sum(known[name].values())) if name in known else None for name in SUMS},
    }


def _mean(values: Mapping[str, float]) -> float | None:
    return float(np.mean([*values.values()])) if values else None


def _interval(values: Mapping[str, float]) -> list[float] | None:
    """Of the mean of values by moment, those of one drive drawn together."""
    _, drive = np.unique([drive_of(moment) for moment in values], return_inverse=True)
    sums, counts = np.bincount(drive, [*values.values()]), np.bincount(drive)
    if len(counts) < 2:
        return None
    samples = draw_resamples(len(counts), RESAMPLES, 0)
    return Sampled(float(sums.sum() / counts.sum()), (samples @ sums) / (samples @ counts)).interval
