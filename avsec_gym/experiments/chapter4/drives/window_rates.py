"""False alarms over windows of ten instants, with their upper bound, and what is detected."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter4.drives.measured_window import (
    MeasuredWindow,
    measured_windows,
)
from avsec_gym.experiments.chapter4.drives.settings import WINDOW
from avsec_gym.experiments.chapter4.settings import ATTACKS, CLEAN, FITTED, JUDGED, RATES
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.roc_curve import threshold_at
from avsec_gym.metrics.tolerance import rate_bound
from avsec_gym.runs.results import Results
from avsec_gym.validation.connected.rays.sequential import SequentialTest, fitted_correlation
from avsec_gym.validation.connected.result import AttackKind

DESIGNATED_DETECTION = 0.95
"""Share of the fitted decidable attacks of each kind that exceed the limit of the last row."""
ONCE, HALF = 1, WINDOW // 2
"""Instants at which an attack is decidable: some one, or half of a window, without which there is
nothing to add up."""
ALL_ALARM = -1.0
"""A limit that every window exceeds, since no evidence is below 0."""
SUMS, PLAIN, SINGLE = "sums over frames", "as if independent", "single frames"
"""What a limit is set to: the cumulative sum along a track, with further frames for as much as
their correlation leaves of them, or whole; or the score of one instant alone."""
_Evidence = Callable[[Floats], Floats]
"""The scores of a track, shape (T,), to what speaks for an attack by each instant, shape (T,)."""


@dataclass(frozen=True)
class KindRates:
    """What becomes of the attacks of a kind that last for whole windows.

    Args:
        detected: All of them: alarms of tracks that are then about the attack.
        covered: Those that some region is about, at some instant.
        decidable: Those of which rays can decide at some instant, see `MeasuredWindow`.
        of_decidable: The detected ones of the decidable ones.
        decidable_half: Those of which rays can decide at half of the instants.
        of_decidable_half: The detected ones of these.
    """

    detected: Share
    covered: Share
    decidable: Share
    of_decidable: Share
    decidable_half: Share
    of_decidable_half: Share


@dataclass(frozen=True)
class WindowRates:
    """What a test over windows is worth, at a limit of the fitted drives.

    Args:
        of: `SUMS`, `PLAIN` or `SINGLE`.
        rate: The designated share of attack-free windows that exceed the limit; None: the limit is
            that which `DESIGNATED_DETECTION` of the decidable attacks exceed, of each kind.
        instants: So many instants these are decidable at, at least, `ONCE` or `HALF`; None where
            there is a rate.
        limit: What a window's evidence must exceed, nats; or `ALL_ALARM`.
        false_alarms: The judged attack-free windows that alarm; a drive is a cluster.
        windows_at_most: The upper bound of that share with 97.5 % confidence.
        drives_at_most: The most attack-free drives that alarm, with 95 % confidence, where a drive
            counts once.
        attacks: What becomes of the judged attacks, by kind.
    """

    of: str
    rate: float | None
    instants: int | None
    limit: float
    false_alarms: Share
    windows_at_most: float
    drives_at_most: float
    attacks: Mapping[AttackKind, KindRates]


@dataclass(frozen=True)
class DrivesSummary:
    """All figures of a run on drives.

    Args:
        fitted: Number of fitted attack-free windows.
        fitted_attacks: Number of fitted attacks, by kind, that lasted and are decidable.
        judged: Number of judged attack-free windows.
        drives: Number of judged drives.
        begun: Number of judged attacks, by kind, those that ended within the window among them.
        correlation: Correlation of the scores of successive instants of a track, of the fitted
            attack-free windows.
        rates: What the test is worth, by statistic and rate.
    """

    fitted: int
    fitted_attacks: Mapping[AttackKind, int]
    judged: int
    drives: int
    begun: Mapping[AttackKind, int]
    correlation: float
    rates: Sequence[WindowRates]


@dataclass(frozen=True, eq=False)
class _Windows:
    """The windows of a part: attack-free ones, and attacks that lasted."""

    clean: Sequence[MeasuredWindow]
    attacked: Mapping[AttackKind, Sequence[MeasuredWindow]]


def drives_summary(run: Results) -> DrivesSummary | None:
    """All figures of a run; None as long as it has no drives of both parts.

    Args:
        run: The results of a run.
    """
    fitted_attacks = {kind: measured_windows(run, FITTED, kind) for kind in ATTACKS}
    judged_attacks = {kind: measured_windows(run, JUDGED, kind) for kind in ATTACKS}
    fitted = _Windows(measured_windows(run, FITTED, CLEAN), _lasting(fitted_attacks))
    judged = _Windows(measured_windows(run, JUDGED, CLEAN), _lasting(judged_attacks))
    if not fitted.clean or not judged.clean:
        return None
    tracks = [track for window in fitted.clean for track in window.scores]
    correlation = fitted_correlation(tracks)
    sums = SequentialTest(correlation=correlation).sums
    return DrivesSummary(
        len(fitted.clean),
        {kind: sum(each.decidable >= ONCE for each in fitted.attacked[kind]) for kind in ATTACKS},
        len(judged.clean),
        len({each.drive for each in judged.clean}),
        {kind: len(judged_attacks[kind]) for kind in ATTACKS},
        correlation,
        [
            *_rates_of(SUMS, sums, fitted, judged),
            *_rates_of(PLAIN, SequentialTest().sums, fitted, judged),
            *_rates_of(SINGLE, _single, fitted, judged),
        ],
    )


def _lasting(
    windows: Mapping[AttackKind, Sequence[MeasuredWindow]],
) -> dict[AttackKind, list[MeasuredWindow]]:
    """Those of a whole window."""
    return {kind: [each for each in windows[kind] if each.lasted == WINDOW] for kind in windows}


def _single(scores: Floats) -> Floats:
    return np.nan_to_num(scores, nan=-np.inf)


def _rates_of(
    of: str, evidence: _Evidence, fitted: _Windows, judged: _Windows
) -> list[WindowRates]:
    """A row for each designated rate, and one for the designated detection."""
    clean = np.array([highest(window, evidence) for window in fitted.clean])
    rows = [_row(of, rate, None, threshold_at(clean, rate), evidence, judged) for rate in RATES]
    for instants in (ONCE, HALF):
        decidable = [
            [highest(each, evidence, about=True) for each in windows if each.decidable >= instants]
            for windows in fitted.attacked.values()
        ]
        if all(decidable):
            limit = min(_exceeded_by_most(np.array(each)) for each in decidable)
            rows.append(_row(of, None, instants, limit, evidence, judged))
    return rows


def highest(window: MeasuredWindow, evidence: _Evidence, about: bool = False) -> float:
    """The most that speaks for an attack at some instant; 0 where nothing does.

    Args:
        window: The window.
        evidence: What adds up along a track.
        about: Whether that counts alone of which the region is then about the attack.
    """
    found = [
        float(by_then[there].max(initial=0.0))
        for scores, within in zip(window.scores, window.about, strict=True)
        for by_then, there in [(evidence(scores), within if about else np.ones_like(within))]
    ]
    return max(found, default=0.0)


def _exceeded_by_most(evidence: Floats) -> float:
    """The largest limit that a share of `DESIGNATED_DETECTION` of the attacks exceeds.

    Where more than the rest of them have no evidence, `ALL_ALARM` is the only one.
    """
    missed = int((1 - DESIGNATED_DETECTION) * len(evidence) + 1e-9)
    least = float(np.sort(evidence)[missed])
    return float(np.nextafter(least, -np.inf)) if least > 0 else ALL_ALARM


def _row(
    of: str,
    rate: float | None,
    instants: int | None,
    limit: float,
    evidence: _Evidence,
    judged: _Windows,
) -> WindowRates:
    alarms = np.array([highest(window, evidence) > limit for window in judged.clean])
    drives = [window.drive for window in judged.clean]
    false_alarms = share_of(alarms, drives)
    loud = {drive for drive, alarm in zip(drives, alarms, strict=True) if alarm}
    assert false_alarms.interval is not None
    return WindowRates(
        of,
        rate,
        instants,
        limit,
        false_alarms,
        false_alarms.interval[1],
        rate_bound(len(set(drives)), len(loud)),
        {kind: _kind(windows, evidence, limit) for kind, windows in judged.attacked.items()},
    )


def _kind(windows: Sequence[MeasuredWindow], evidence: _Evidence, limit: float) -> KindRates:
    # Where all windows alarm, what no region is about is still not detected.
    detected = np.array(
        [each.covered and highest(each, evidence, about=True) > limit for each in windows],
        bool,
    )
    decidable = np.array([each.decidable >= ONCE for each in windows], bool)
    half = np.array([each.decidable >= HALF for each in windows], bool)
    covered = np.array([each.covered for each in windows], bool)
    drives = np.array([each.drive for each in windows])

    def share(hits: NDArray[np.bool_], of: NDArray[np.bool_]) -> Share:
        return share_of(hits[of], drives[of].tolist())

    every = np.ones(len(windows), bool)
    return KindRates(
        share(detected, every),
        share(covered, every),
        share(decidable, every),
        share(detected, decidable),
        share(half, every),
        share(detected, half),
    )
