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
from avsec_gym.experiments.chapter5.settings import UNATTACKED
from avsec_gym.geometry import Floats
from avsec_gym.metrics.average_precision import METRICS
from avsec_gym.metrics.average_precision_curves import draw_resamples
from avsec_gym.metrics.average_precision_frames import LEVELS
from avsec_gym.metrics.paired import paired_differences

_PLACE = (0, METRICS.index("3d"), LEVELS.index("moderate"))
_AP11 = 0
_LOW_AND_HIGH = (0.025, 0.975)


@dataclass(frozen=True, eq=False)
class Losses:
    """What one attack takes, in percentage points; of each bootstrap sample of scenarios, too.

    Args:
        condition: The attack.
        precision: Of average precision (3D, moderate, 11 points), and its samples, shape (R,).
        safety: Of the safe driving rate over all intentions, and its samples, shape (R,).
    """

    condition: Condition
    precision: tuple[float, Floats]
    safety: tuple[float, Floats]


def decoupling(outcomes: Outcomes) -> dict[str, Any]:
    """The losses under every attack, and how far they go together."""
    every = losses(outcomes)
    by_detector = {
        name: [one for one in every if one.condition.detector == name]
        for name in dict.fromkeys(one.condition.detector for one in every)
    }
    return {
        "scenarios": len(outcomes.scenarios),
        "attacks": [_row(outcomes, one) for one in every],
        "rank_correlation": {
            name: rank_correlation(some) for name, some in (*by_detector.items(), ("both", every))
        },
        "discordant_pairs": {name: discordant_pairs(some) for name, some in by_detector.items()},
    }


def losses(outcomes: Outcomes) -> list[Losses]:
    """Of every attack, in the order of `Outcomes.conditions`."""
    samples = draw_resamples(len(outcomes.scenarios), RESAMPLES, 0)
    found: dict[Condition, tuple[tuple[float, Floats], tuple[float, Floats]]] = {}
    for condition in outcomes.conditions:
        precisions = [
            outcomes.precision(condition, intention) for intention in outcomes.looks(condition)
        ]
        precision = float(np.mean([one.ap11[_PLACE] for one in precisions]))
        drawn = np.mean([_samples(one.drawn) for one in precisions], axis=0)
        safe = safe_by_scenario(outcomes.records(condition), outcomes.scenarios)
        rate = 100 * safe[:, 0].sum() / safe[:, 1].sum()
        rates = 100 * (samples @ safe[:, 0]) / (samples @ safe[:, 1])
        found[condition] = (precision, drawn), (float(rate), rates)
    return [
        Losses(condition, *(_lost(*pair) for pair in zip(before, after, strict=True)))
        for condition, after in found.items()
        if condition.attack != UNATTACKED and condition.unattacked in found
        for before in [found[condition.unattacked]]
    ]


def rank_correlation(some: Sequence[Losses]) -> dict[str, Any]:
    """Spearman's, of the loss of precision and that of safety, with its bootstrap interval.

    Each sample draws scenarios, and takes both losses of every attack from the same draw.
    """
    if len(some) < 3:
        return {"attacks": len(some), "rho": None, "interval": None}
    pairs = np.array([[one.precision[0], one.safety[0]] for one in some])
    drawn = np.array([[one.precision[1], one.safety[1]] for one in some])  # (attacks, 2, R)
    drawn = drawn[:, :, np.isfinite(drawn).all(axis=(0, 1))]
    values = [_spearman(drawn[:, 0, i], drawn[:, 1, i]) for i in range(drawn.shape[2])]
    known = [value for value in values if value is not None]
    return {
        "attacks": len(some),
        "rho": _spearman(pairs[:, 0], pairs[:, 1]),
        "interval": [float(q) for q in np.quantile(known, _LOW_AND_HIGH)] if known else None,
    }


def discordant_pairs(some: Sequence[Losses]) -> dict[str, int]:
    """Pairs of attacks of which one surely takes more precision, and surely less safety.

    Surely: the 95 % interval of the difference leaves zero out, in both.
    """
    count = {"pairs": 0, "concordant": 0, "discordant": 0}
    for one, other in combinations(some, 2):
        signs = []
        for (_, first), (_, second) in (
            (one.precision, other.precision),
            (one.safety, other.safety),
        ):
            low, high = np.nanquantile(first - second, _LOW_AND_HIGH)
            signs.append(int(low > 0) - int(high < 0))
        product = signs[0] * signs[1]
        count["pairs"] += 1
        count["concordant"] += product > 0
        count["discordant"] += product < 0
    return count


def _row(outcomes: Outcomes, one: Losses) -> dict[str, Any]:
    condition = one.condition
    return {
        "detector": condition.detector,
        "attack": condition.attack,
        "strength": condition.strength,
        "whole_levels": condition.whole_levels,
        "precision_lost": one.precision[0],
        "precision_lost_interval": _interval(one.precision[1]),
        "safety_lost": one.safety[0],
        "safety_lost_interval": _interval(one.safety[1]),
        "paired": paired_differences(
            outcomes.records(condition.unattacked), outcomes.records(condition)
        ),
    }


def _samples(drawn: Floats | None) -> Floats:
    assert drawn is not None, "precision was asked for with samples"
    return drawn[_PLACE][:, _AP11]


def _lost(before: tuple[float, Floats], after: tuple[float, Floats]) -> tuple[float, Floats]:
    return before[0] - after[0], before[1] - after[1]


def _interval(values: Floats) -> list[float] | None:
    known = values[np.isfinite(values)]
    return [float(q) for q in np.quantile(known, _LOW_AND_HIGH)] if len(known) else None


def _spearman(first: Floats, second: Floats) -> float | None:
    """None where one of them does not vary."""
    a, b = rankdata(first), rankdata(second)
    if not (a.std() and b.std()):
        return None
    return float(np.corrcoef(a, b)[0, 1])
