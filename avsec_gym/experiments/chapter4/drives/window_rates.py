"""False alarms over windows of ten instants, with their upper bound, and what is detected."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter4.drives.settings import (
    DRIVE_METHODS,
    GHOST,
    WINDOW,
    drive_setting,
)
from avsec_gym.experiments.chapter4.settings import CLEAN, FITTED, JUDGED, RATES, Part, State
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.roc_curve import threshold_at
from avsec_gym.runs.results import Results
from avsec_gym.validation.connected.rays.sequential import (
    SequentialTest,
    bound_on_false_alarms,
    fit_limit,
    share_of_alarms,
)
from avsec_gym.validation.connected.validator import Method

DESIGNATED_DETECTION = 0.95
"""Share of the decidable attacked windows that are detected where false alarms are stated at it."""


@dataclass(frozen=True, eq=False)
class DriveWindows:
    """The windows of the drives of one part in one state.

    Args:
        scores: The highest score of each instant, by method: W windows, shape (`WINDOW`,) each, NaN
            where nothing was compared.
        drives: The drive of each window, W names.
        decidable: Whether the ghost was decidable at one instant at least, W of them.
    """

    scores: Mapping[Method, Sequence[Floats]]
    drives: Sequence[str]
    decidable: Sequence[bool]

    def __len__(self) -> int:
        return len(self.drives)


@dataclass(frozen=True)
class WindowRates:
    """What a test over windows is worth.

    Args:
        method: The method.
        rate: The designated share of windows that alarm falsely; None: the limit is that at which
            `DESIGNATED_DETECTION` of the judged decidable attacks are detected.
        limit: The limit of the sum, nats.
        false_alarms: The judged attack-free windows that alarm; a drive is a cluster.
        drives: The most attack-free drives that alarm, with 95 % confidence, see
            `bound_on_false_alarms`.
        detected: The attacked windows that alarm.
        of_decidable: The share of those in which the ghost is decidable at some instant.
        by_highest: The share that a single instant would detect: its highest score above a
            threshold that as many attack-free windows of the fitted drives exceed.  Without a case
            where the rate is None.
    """

    method: Method
    rate: float | None
    limit: float
    false_alarms: Share
    drives: float
    detected: Share
    of_decidable: Share
    by_highest: Share


@dataclass(frozen=True)
class DrivesSummary:
    """All figures of a run on drives.

    Args:
        fitted: Number of fitted attack-free windows.
        judged: Number of judged attack-free windows.
        attacked: Number of attacked windows.
        rates: What the test is worth, by method and rate.
    """

    fitted: int
    judged: int
    attacked: int
    rates: Sequence[WindowRates]


def drives_summary(run: Results) -> DrivesSummary | None:
    """All figures of a run; None as long as it has no drives of both parts.

    Args:
        run: The results of a run.
    """
    fitted, clean = drive_windows(run, FITTED, CLEAN), drive_windows(run, JUDGED, CLEAN)
    attacked = drive_windows(run, JUDGED, GHOST)
    if not len(fitted) or not len(clean):
        return None
    rates = [row for method in DRIVE_METHODS for row in _rates_of(method, fitted, clean, attacked)]
    return DrivesSummary(len(fitted), len(clean), len(attacked), rates)


def drive_windows(run: Results, part: Part, state: State) -> DriveWindows:
    """The whole windows that a run holds, drive by drive.

    Args:
        run: The results of a run.
        part: `FITTED` or `JUDGED`.
        state: The state.
    """
    found: dict[str, dict[str, float]] = {}
    for row in run.measurements(setting=drive_setting(part, state)):
        found.setdefault(row.scenario, {})[row.name] = row.value
    scores: dict[Method, list[Floats]] = {method: [] for method in DRIVE_METHODS}
    drives, decidable = [], []
    for drive, values in sorted(found.items()):
        frames = {int(name.rpartition(" ")[2]) for name in values}
        for start in range(0, max(frames) + 1, WINDOW):
            window = range(start, start + WINDOW)
            # A ghost that the victim drives into ends: what is left is no window.
            if not frames.issuperset(window):
                continue
            for method in DRIVE_METHODS:
                scores[method].append(np.array([values[f"{method} {frame}"] for frame in window]))
            drives.append(drive)
            decidable.append(any(values.get(f"decidable {frame}", 0.0) > 0 for frame in window))
    return DriveWindows(scores, drives, decidable)


def _rates_of(
    method: Method, fitted: DriveWindows, clean: DriveWindows, attacked: DriveWindows
) -> list[WindowRates]:
    rows = []
    for rate in RATES:
        test = fit_limit(fitted.scores[method], rate)
        single = threshold_at(_highest(fitted.scores[method]), rate)
        by_highest = share_of(_highest(attacked.scores[method]) > single, attacked.drives)
        rows.append(_row(method, rate, test, clean, attacked, by_highest))
    decidable = [
        scores
        for scores, some in zip(attacked.scores[method], attacked.decidable, strict=True)
        if some
    ]
    if decidable:
        sums = np.sort([SequentialTest().sums(scores).max() for scores in decidable])
        missed = int((1 - DESIGNATED_DETECTION) * len(sums))
        # A limit of 0 is none: then what never rises above it cannot be detected at any rate.
        test = SequentialTest(max(float(sums[missed]), 1e-6))
        rows.append(_row(method, None, test, clean, attacked, share_of([], [])))
    return rows


def _row(
    method: Method,
    rate: float | None,
    test: SequentialTest,
    clean: DriveWindows,
    attacked: DriveWindows,
    by_highest: Share,
) -> WindowRates:
    scores, drives = attacked.scores[method], attacked.drives
    some = np.flatnonzero(attacked.decidable).tolist()
    return WindowRates(
        method,
        rate,
        test.limit,
        share_of_alarms(test, clean.scores[method], clean.drives),
        bound_on_false_alarms(test, clean.scores[method], clean.drives),
        share_of_alarms(test, scores, drives),
        share_of_alarms(test, [scores[i] for i in some], [drives[i] for i in some]),
        by_highest,
    )


def _highest(windows: Sequence[Floats]) -> Floats:
    """The highest score of each window; -inf where nothing was compared."""
    known = [np.where(np.isnan(scores), -np.inf, scores) for scores in windows]
    return np.array([scores.max() for scores in known], float)
