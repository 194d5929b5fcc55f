"""Results of drives, setting by setting: rates and means with intervals, and differences."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from avsec_gym.closed_loop.drive_record import Outcome
from avsec_gym.drives.drive_row import DriveRow
from avsec_gym.drives.one_drive import HARD_BRAKING
from avsec_gym.geometry import Floats
from avsec_gym.metrics.cluster_bootstrap import mean_over_clusters
from avsec_gym.metrics.clustered_shares import Share, share_of

Cluster = Callable[[DriveRow], str]
_RESAMPLES = 10_000
RATES: Mapping[str, Callable[[DriveRow], bool]] = {
    "at_fault": lambda row: bool(row["at_fault"]),
    "collision": lambda row: bool(row["collision"]),
    "goal": lambda row: row["outcome"] == Outcome.GOAL,
    "hard_braking": lambda row: row["hardest_braking"] > HARD_BRAKING,
    "alarm": lambda row: row["alarms"] > 0,
}
"""Rates, and which drives each counts."""


@dataclass(frozen=True)
class Mean:
    """A mean over drives.

    Args:
        value: The mean.
        interval: The 95 % interval, low and high; None of a single scene.
    """

    value: float
    interval: tuple[float, float] | None


@dataclass(frozen=True)
class SettingSummary:
    """Rates and means of the drives of one setting.

    Args:
        setting: The setting's name.
        drives: How many.
        scenes: The number of scenes; drives of one are alike, which intervals heed.
        rates: Shares of the drives, by the names of `RATES`.
        navsim_score: Mean of NAVSIM's score.
        outcomes: How many drives ended in each way.
        steps: Steps of all drives.
        differences: Differences to the first setting on the same drives: of ``at_fault`` (in
            shares of the drives) and of ``navsim_score``; empty for the first one.
    """

    setting: str
    drives: int
    scenes: int
    rates: Mapping[str, Share]
    navsim_score: Mean
    outcomes: Mapping[str, int]
    steps: int
    differences: Mapping[str, Mean]

    def to_json(self) -> dict[str, Any]:
        """All of it, as JSON."""
        return asdict(self)


def by_scene(row: DriveRow) -> str:
    """Drives of one scene are one cluster."""
    return str(row["scenario"])


def by_recording(row: DriveRow) -> str:
    """Windows of one recording, such as ``0009-000120``, are one cluster: they overlap."""
    return str(row["scenario"]).rpartition("-")[0]


def summaries(
    rows: Iterable[DriveRow], settings: Sequence[str], cluster: Cluster = by_scene
) -> list[SettingSummary]:
    """The summary of each setting that has drives.

    Args:
        rows: Rows of drives.
        settings: Names, in the order of the table; differences are to the first one.
        cluster: The drives that are one cluster for the intervals.
    """
    by_setting: dict[str, list[DriveRow]] = {name: [] for name in settings}
    for row in rows:
        by_setting[row["setting"]].append(row)
    first = by_setting[settings[0]]
    return [
        _summary(name, own, [] if name == settings[0] else first, cluster)
        for name, own in by_setting.items()
        if own
    ]


def _summary(
    name: str, rows: list[DriveRow], first: list[DriveRow], cluster: Cluster
) -> SettingSummary:
    clusters = [cluster(row) for row in rows]
    return SettingSummary(
        setting=name,
        drives=len(rows),
        scenes=len({row["scenario"] for row in rows}),
        rates={
            rate: share_of([counts(row) for row in rows], clusters)
            for rate, counts in RATES.items()
        },
        navsim_score=mean_over_scenes(np.array([row["navsim_score"] for row in rows]), clusters),
        outcomes={
            str(each): sum(row["outcome"] == each for row in rows)
            for each in Outcome
            if any(row["outcome"] == each for row in rows)
        },
        steps=sum(row["steps"] for row in rows),
        differences=_differences(rows, first, cluster),
    )


def _differences(rows: list[DriveRow], first: list[DriveRow], cluster: Cluster) -> dict[str, Mean]:
    """Over the drives that both have made."""
    before = {(row["scenario"], row["intention"]): row for row in first}
    pairs = [
        (row, before[key]) for row in rows if (key := (row["scenario"], row["intention"])) in before
    ]
    if not pairs:
        return {}
    clusters = [cluster(row) for row, _ in pairs]
    differences = {
        "at_fault": [float(row["at_fault"]) - float(other["at_fault"]) for row, other in pairs],
        "navsim_score": [row["navsim_score"] - other["navsim_score"] for row, other in pairs],
    }
    return {name: mean_over_scenes(np.array(own), clusters) for name, own in differences.items()}


def mean_over_scenes(values: Floats, scenes: Sequence[str]) -> Mean:
    """A mean with the 95 % percentile interval of a bootstrap that draws whole scenes.

    Args:
        values: A value of each drive, shape (N,), N one or more.
        scenes: The scene, or whatever else is a cluster, that each drive is of; N names.
    """
    mean = mean_over_clusters(values, scenes, resamples=_RESAMPLES)
    interval = mean.interval
    return Mean(mean.value, None if interval is None else (interval[0], interval[1]))
