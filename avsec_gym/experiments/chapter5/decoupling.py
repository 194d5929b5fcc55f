"""The thesis' claim, held against the data: are precision and driving safety decoupled?

For every attack: how much of the precision it takes, and how much of the safe drives.  If the two
went together, the attack that takes more of one would take more of the other: their rank
correlation says how far that holds, its interval how sure that is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from scipy.stats import rankdata

from avsec_gym.experiments.chapter5.outcomes import (
    RESAMPLES,
    Condition,
    Outcomes,
    safe_by_scenario,
)
from avsec_gym.experiments.chapter5.settings import (
    JOINT_PATCHES,
    PATCHES,
    PERTURBATIONS,
    UNATTACKED,
)
from avsec_gym.geometry import Floats
from avsec_gym.metrics.average_precision import METRICS, STANDARD_IOU, MinIou
from avsec_gym.metrics.average_precision_curves import draw_resamples
from avsec_gym.metrics.average_precision_frames import LEVELS
from avsec_gym.metrics.paired import paired_differences

_PLACE = (0, METRICS.index("3d"), LEVELS.index("moderate"))
_AP11 = 0
_LOW_AND_HIGH = (0.025, 0.975)
TRUE_ATTACKS = PERTURBATIONS + PATCHES + JOINT_PATCHES
"""Controls, and attacks on changed scenes, are no attacks to compare."""


@dataclass(frozen=True, eq=False)
class Sampled:
    """A figure, and what it is in each bootstrap sample of scenarios; samples are shared by all."""

    value: float
    samples: Floats
    """Shape (R,); NaN where a sample has nothing to measure."""

    def __sub__(self, other: Sampled) -> Sampled:
        return Sampled(self.value - other.value, self.samples - other.samples)

    @property
    def interval(self) -> list[float] | None:
        """95 %, low and high."""
        known = self.samples[np.isfinite(self.samples)]
        return [float(q) for q in np.quantile(known, _LOW_AND_HIGH)] if len(known) else None

    @property
    def interval_around(self) -> list[float] | None:
        """`interval`, widened to hold the figure itself.

        Drawing adds noise, which lowers correlations: one near 1 may lie above nearly all draws.
        """
        interval = self.interval
        return interval and [min(interval[0], self.value), max(interval[1], self.value)]


@dataclass(frozen=True, eq=False)
class Losses:
    """What one attack takes, in percentage points.

    Args:
        condition: The attack.
        precision: Of average precision (3D, moderate, 11 points).
        safety: Of the safe driving rate over all intentions.
    """

    condition: Condition
    precision: Sampled
    safety: Sampled

    @property
    def counts(self) -> bool:
        """Whether it is one of the attacks that the correlation is about."""
        return self.condition.attack in TRUE_ATTACKS and not self.condition.whole_levels


def decoupling(outcomes: Outcomes) -> dict[str, Any]:
    """The losses under every attack, and how far they go together.

    Correlation and pairs are those of perturbations and patches in float; controls, rounded
    pixels and changed scenes have rows of their own only.
    """
    every = losses(outcomes)
    attacks = [one for one in every if one.counts]
    by_detector = {
        name: [one for one in attacks if one.condition.detector == name]
        for name in dict.fromkeys(one.condition.detector for one in attacks)
    }
    return {
        "scenarios": len(outcomes.scenarios),
        "unattacked": [
            _unattacked_row(outcomes, condition)
            for condition in outcomes.conditions
            if condition.attack == UNATTACKED
        ],
        "attacks": [_row(outcomes, one) for one in every],
        "rank_correlation": {
            name: rank_correlation(some) for name, some in (*by_detector.items(), ("both", attacks))
        },
        "discordant_pairs": {name: discordant_pairs(some) for name, some in by_detector.items()},
    }


def losses(outcomes: Outcomes) -> list[Losses]:
    """Of every condition but the unattacked, in the order of `Outcomes.conditions`."""
    found = {one: (precision(outcomes, one), safety(outcomes, one)) for one in outcomes.conditions}
    return [
        Losses(condition, *(before - after for before, after in zip(clean, attacked, strict=True)))
        for condition, attacked in found.items()
        if condition.attack != UNATTACKED and condition.unattacked in found
        for clean in [found[condition.unattacked]]
    ]


def precision(outcomes: Outcomes, condition: Condition, min_iou: MinIou = STANDARD_IOU) -> Sampled:
    """Average precision of cars in percent; of a specific patch the mean over the intentions."""
    looks = outcomes.looks(condition)
    found = [outcomes.precision(condition, intention, min_iou) for intention in looks]
    value = float(np.mean([one.ap11[_PLACE] for one in found]))
    return Sampled(value, np.mean([_samples(one.drawn) for one in found], axis=0))


def safety(outcomes: Outcomes, condition: Condition) -> Sampled:
    """Safe driving rate over all intentions, percent, in the same samples as `precision`."""
    samples = draw_resamples(len(outcomes.scenarios), RESAMPLES, 0)
    safe, drives = safe_by_scenario(outcomes.records(condition), outcomes.scenarios).T
    return Sampled(
        100 * float(safe.sum() / drives.sum()), 100 * (samples @ safe) / (samples @ drives)
    )


def rank_correlation(some: Sequence[Losses]) -> dict[str, Any]:
    """Spearman's, of the loss of precision and that of safety, with its bootstrap interval.

    Each sample draws scenarios, and takes both losses of every attack from the same draw; the
    interval is widened to hold the figure itself.
    """
    rho = spearman([(one.precision, one.safety) for one in some])
    if rho is None:
        return {"attacks": len(some), "rho": None, "interval": None}
    return {"attacks": len(some), "rho": rho.value, "interval": rho.interval_around}


def spearman(pairs: Sequence[tuple[Sampled, Sampled]]) -> Sampled | None:
    """The rank correlation of two figures of several things, in each sample.

    Args:
        pairs: Of each thing; None results from fewer than three, or where one figure never varies.
    """
    if len(pairs) < 3:
        return None
    drawn = np.array([[one.samples for one in pair] for pair in pairs])  # (things, 2, R)
    rho = float(_spearman(np.array([[[one.value] for one in pair] for pair in pairs]))[0])
    return Sampled(rho, _spearman(drawn)) if np.isfinite(rho) else None


def discordant_pairs(some: Sequence[Losses]) -> dict[str, Any]:
    """Pairs of attacks of which one surely takes more precision, and surely less safety.

    Surely: the 95 % interval of the difference leaves zero out, in both.  ``example`` is the
    discordant pair whose differences are the largest, as conditions: the one that takes more
    precision first.
    """
    count: dict[str, Any] = {"pairs": 0, "concordant": 0, "discordant": 0, "example": None}
    largest = 0.0
    for one, other in combinations(some, 2):
        differences = (one.precision - other.precision, one.safety - other.safety)
        signs = [_sure_sign(difference) for difference in differences]
        count["pairs"] += 1
        count["concordant"] += signs[0] * signs[1] > 0
        if signs[0] * signs[1] < 0:
            count["discordant"] += 1
            size = abs(differences[0].value * differences[1].value)
            if size > largest:
                first, second = (one, other) if signs[0] > 0 else (other, one)
                largest, count["example"] = size, [_named(first), _named(second)]
    return count


def _sure_sign(difference: Sampled) -> int:
    interval = difference.interval
    return 0 if interval is None else int(interval[0] > 0) - int(interval[1] < 0)


def _named(one: Losses) -> dict[str, Any]:
    return {
        **vars(one.condition),
        "precision_lost": one.precision.value,
        "precision_lost_interval": one.precision.interval,
        "safety_lost": one.safety.value,
        "safety_lost_interval": one.safety.interval,
    }


def _row(outcomes: Outcomes, one: Losses) -> dict[str, Any]:
    clean, attacked = (
        outcomes.records(condition) for condition in (one.condition.unattacked, one.condition)
    )
    return {**_named(one), "counts": one.counts, "paired": paired_differences(clean, attacked)}


def _unattacked_row(outcomes: Outcomes, condition: Condition) -> dict[str, Any]:
    before, safe = precision(outcomes, condition), safety(outcomes, condition)
    return {
        "detector": condition.detector,
        "precision": before.value,
        "precision_interval": before.interval,
        "safety": safe.value,
        "safety_interval": safe.interval,
    }


def _samples(drawn: Floats | None) -> Floats:
    assert drawn is not None, "precision was asked for with samples"
    return drawn[_PLACE][:, _AP11]


def _spearman(pairs: Floats) -> Floats:
    """Of pairs of shape (n, 2, R), shape (R,); NaN where one of the two does not vary."""
    ranks = rankdata(pairs, axis=0) - (len(pairs) + 1) / 2
    spread = np.sqrt((ranks**2).sum(axis=0))
    with np.errstate(invalid="ignore"):
        return np.asarray((ranks[:, 0] * ranks[:, 1]).sum(axis=0) / (spread[0] * spread[1]))
