"""How well damage is located and repaired, attack by attack."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from avsec_gym.experiments.chapter3.localisation.measures import CAR, attacks_of
from avsec_gym.experiments.chapter3.localisation.repaired_frames import LOCALISATION_OPTIONS
from avsec_gym.experiments.chapter3.recordings import SYSTEM
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES
from avsec_gym.metrics.cluster_bootstrap import mean_over_clusters
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results
from avsec_gym.validation.recordings import drive_of

BOGUS_SEEN = ("bogus_clean", "bogus_before", "bogus_after")
"""Whether a detector of scans sees an obstacle where bogus points are, in three scans."""
MEANS = ("precision", "recall", "iou_of_lost", "error_before", "error_after", *BOGUS_SEEN)
SUMS = ("objects", "found_before", "found_cleaned", "found_after")
"""Measures of `measures_of`, and counts of objects."""


@dataclass(frozen=True)
class LocatedFrame:
    """How well the damage of one frame is located.

    Args:
        frame: The frame's id.
        iou: Intersection over union of the found and the true damage.
    """

    frame: str
    iou: float


@dataclass(frozen=True)
class LocatedAttack:
    """How well the damage of one attack is located and repaired; None where nothing was measured.

    Args:
        attack: The attack's name.
        frames: How many frames.
        iou: Mean intersection over union of the found and the true damage.
        interval: 95 % of the mean, bootstrap over drives; None of a single drive.
        lowest: The frame with the lowest IoU.
        median: The frame with the median IoU.
        precision: Mean share of what was found that is damaged.
        recall: Mean share of the damage that was found.
        iou_of_lost: Mean IoU of lost returns.
        error_before: Mean difference to the clean image where it was damaged, grey levels.
        error_after: The same after the repair.
        bogus_clean: Share of clean scans with an obstacle where the bogus points will be.
        bogus_before: The same of attacked scans.
        bogus_after: The same of repaired scans.
        objects: Objects that a detector finds in the clean frames.
        found_before: How many of them it finds in the attacked ones.
        found_cleaned: The same in scans that only lack what was found bogus.
        found_after: The same in the repaired ones.
    """

    attack: str
    frames: int
    iou: float | None
    interval: Sequence[float] | None
    lowest: LocatedFrame | None
    median: LocatedFrame | None
    precision: float | None
    recall: float | None
    iou_of_lost: float | None
    error_before: float | None
    error_after: float | None
    bogus_clean: float | None
    bogus_before: float | None
    bogus_after: float | None
    objects: int | None
    found_before: int | None
    found_cleaned: int | None
    found_after: int | None


@dataclass(frozen=True)
class LocalisationSummary:
    """The results of a run on damage located and repaired.

    Args:
        detector: The detector of images that looked at repaired frames; empty: none.
        score_threshold: The score from which on its boxes count.
        scan_detector: The detector of scans; empty: none.
        scan_score_threshold: The score from which on its boxes count.
        attacks: One row for each attack.
    """

    detector: str
    score_threshold: float
    scan_detector: str
    scan_score_threshold: float
    attacks: Sequence[LocatedAttack]


def localisation_summary(
    results: Results, configuration: Configuration
) -> LocalisationSummary | None:
    """Means over the frames of each attack; None without any."""
    rows = []
    for attack in (*attacks_of(SYSTEM.reference), CAR):
        found: dict[str, dict[str, float]] = {}
        for row in results.measurements(setting=attack):
            found.setdefault(row.name, {})[row.scenario] = row.value
        if found:
            rows.append(_row(attack, found))
    options = {**LOCALISATION_OPTIONS, **configuration.options}
    names = ("detector", "score_threshold", "scan_detector", "scan_score_threshold")
    detectors = {name: options[name] for name in names}
    return LocalisationSummary(**detectors, attacks=rows) if rows else None


def _row(attack: str, found: Mapping[str, Mapping[str, float]]) -> LocatedAttack:
    """The row of one attack.

    Args:
        attack: The attack's name.
        found: Values by name and frame; NaN where there is none.
    """
    known = {
        name: {id: value for id, value in values.items() if not math.isnan(value)}
        for name, values in found.items()
    }
    iou = known["iou"]
    order = sorted(iou, key=lambda id: (iou[id], id))
    shown = [order[0], order[(len(order) - 1) // 2]] if order else []
    lowest, median = [LocatedFrame(id, iou[id]) for id in shown] or (None, None)
    measured: dict[str, Any] = {name: _mean(known.get(name, {})) for name in MEANS}
    for name in SUMS:
        measured[name] = int(sum(known[name].values())) if name in known else None
    return LocatedAttack(
        attack,
        len(found["iou"]),
        _mean(iou),
        _interval(iou),
        lowest,
        median,
        **measured,
    )


def _mean(values: Mapping[str, float]) -> float | None:
    return float(np.mean([*values.values()])) if values else None


def _interval(values: Mapping[str, float]) -> list[float] | None:
    """Of the mean of values by frame, those of one drive drawn together."""
    drives = [drive_of(id) for id in values]
    return mean_over_clusters([*values.values()], drives, resamples=RESAMPLES).interval
