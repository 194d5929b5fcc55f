"""The chapter's question within families of attacks, and what a point of precision costs in each.

Perturbations take cars, patches add ghosts.  A correlation over attacks of both asks two things at
once: whether, within a family, the attack that takes more precision takes more safety, and whether
a point of precision costs as much safety whichever family takes it.  Where the second does not
hold, the correlation over all attacks may vanish although the first holds in every family.  Both
are asked apart here; the second by the exchange rate, the safety that a family takes for each point
of precision.

All figures of a detector are sampled in the same bootstrap draws of scenarios, each with all its
attacks and intentions (see `losses`), so that ratios and differences are paired.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from avsec_gym.experiments.chapter5.decoupling import RankCorrelation, rank_correlation
from avsec_gym.experiments.chapter5.losses import Losses, losses
from avsec_gym.experiments.chapter5.outcomes import Outcomes
from avsec_gym.experiments.chapter5.pairs_of_attacks import (
    ComparedPair,
    DiscordantPairs,
    compared_pairs,
    counted_pairs,
)
from avsec_gym.experiments.chapter5.settings import FAMILIES
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.metrics.cluster_bootstrap import Sampled
from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.metrics.many_comparisons import holm_adjusted

ALL_FAMILIES = "all"
"""All attacks that count, of whatever family."""
SURELY_ABOVE_ZERO = 0.975
"""Share of bootstrap samples in which a loss has to be above zero to be divided by."""


@dataclass(frozen=True)
class FamilyRow:
    """The attacks of a family on one detector.

    Args:
        detector: The detector.
        family: One of `FAMILIES`, or `ALL_FAMILIES`.
        correlation: The rank correlation of the loss of precision with that of safety.
        precision_lost: What an attack takes of the average precision in the mean, points.
        safety_lost: What an attack takes of the safe driving rate in the mean, points.
        exchange_rate: Points of safe driving lost for each point of average precision: the ratio of
            the two; unknown where no precision is surely lost.
        pairs: Pairs within the family, corrected for all pairs of the detector.
    """

    detector: str
    family: str
    correlation: RankCorrelation = field(metadata=FLAT)
    precision_lost: Estimate
    safety_lost: Estimate
    exchange_rate: Estimate
    pairs: DiscordantPairs


@dataclass(frozen=True)
class ComparedFamilies:
    """Two families of attacks on one detector.

    Args:
        detector: The detector.
        first: The family whose exchange rate is compared.
        second: The family that it is compared with.
        ratio: How many times as much safety a point of precision costs that the first takes;
            unknown where the second's rate is not surely above zero.
        difference: How much more it costs, points of safety for a point of precision.
        p_holm: The p-value of the difference's being zero, see `rates_differ`, after Holm's
            correction for all comparisons of the run; None where a rate is unknown.
        pairs: Pairs of an attack of each, corrected for all pairs of the detector.
    """

    detector: str
    first: str
    second: str
    ratio: Estimate
    difference: Estimate
    p_holm: float | None
    pairs: DiscordantPairs


@dataclass(frozen=True)
class FamilyFigures:
    """The chapter's question by family of attacks.

    Args:
        rows: A row for each detector and family that it is attacked by, the whole first.
        compared: A row for each detector and two families.
    """

    rows: Sequence[FamilyRow]
    compared: Sequence[ComparedFamilies]


def family_figures(outcomes: Outcomes) -> FamilyFigures:
    """Correlation, exchange rate and pairs of each family, for each detector.

    Args:
        outcomes: The outcomes of a run.
    """
    return figures_of([attack for attack in losses(outcomes) if attack.counts])


def figures_of(attacks: Sequence[Losses]) -> FamilyFigures:
    """The same of some attacks.

    Args:
        attacks: Losses of attacks, those of one detector sampled in the same draws.
    """
    rows: list[FamilyRow] = []
    compared: list[tuple[ComparedFamilies, float]] = []
    for detector in dict.fromkeys(attack.condition.detector for attack in attacks):
        own = [attack for attack in attacks if attack.condition.detector == detector]
        members = {
            family: group
            for family, names in FAMILIES.items()
            if (group := [attack for attack in own if attack.condition.attack in names])
        }
        pairs = compared_pairs(own)
        rows.append(_family_row(detector, ALL_FAMILIES, own, pairs))
        for family, group in members.items():
            within = [pair for pair in pairs if _families_of(pair) == {family}]
            rows.append(_family_row(detector, family, group, within))
        for second, first in combinations(members, 2):
            between = [pair for pair in pairs if _families_of(pair) == {first, second}]
            both = members[first], members[second]
            compared.append(_compared(detector, (first, second), both, between))
    corrected = holm_adjusted([p for _, p in compared])
    return FamilyFigures(
        rows,
        [
            replace(row, p_holm=None if np.isnan(p) else float(p))
            for (row, _), p in zip(compared, corrected, strict=True)
        ],
    )


def exchange_rate(attacks: Sequence[Losses]) -> Sampled | None:
    """Points of safe driving that attacks take for each point of average precision.

    The ratio of the two sums over the attacks: one that takes much counts more than one that takes
    next to nothing, whose own ratio would be noise.

    Args:
        attacks: One or more, sampled in the same draws.

    Returns:
        None where no precision is surely lost.

    Example:
        >>> from avsec_gym.experiments.chapter5.outcomes import Condition
        >>> taken = Sampled(20.0, np.full(3, 20.0)), Sampled(5.0, np.full(3, 5.0))
        >>> exchange_rate([Losses(Condition("dsgn", "patch-random"), *taken)]).value
        0.25
    """
    return _ratio(
        _mean([attack.safety for attack in attacks]),
        _mean([attack.precision for attack in attacks]),
    )


def _family_row(
    detector: str, family: str, attacks: Sequence[Losses], pairs: Sequence[ComparedPair]
) -> FamilyRow:
    rate = exchange_rate(attacks)
    return FamilyRow(
        detector,
        family,
        rank_correlation(attacks),
        _mean([attack.precision for attack in attacks]).estimate,
        _mean([attack.safety for attack in attacks]).estimate,
        NOTHING if rate is None else rate.estimate,
        counted_pairs(pairs),
    )


def _compared(
    detector: str,
    families: tuple[str, str],
    members: tuple[Sequence[Losses], Sequence[Losses]],
    between: Sequence[ComparedPair],
) -> tuple[ComparedFamilies, float]:
    """A row without its corrected p-value, and the p-value itself; NaN without any."""
    first, second = map(exchange_rate, members)
    difference = None if first is None or second is None else first - second
    ratio = None if first is None or second is None else _ratio(first, second)
    row = ComparedFamilies(
        detector,
        *families,
        NOTHING if ratio is None else ratio.estimate,
        NOTHING if difference is None else difference.estimate,
        None,
        counted_pairs(between),
    )
    return row, np.nan if difference is None else rates_differ(*members).p


def rates_differ(first: Sequence[Losses], second: Sequence[Losses]) -> Sampled:
    """A figure that is zero where two families have one exchange rate.

    ``S_1 / P_1 = S_2 / P_2`` where ``S_1 P_2 - S_2 P_1 = 0``, and unlike a ratio whose divisor
    comes near zero in some draws this has a spread that tells something (in the spirit of Fieller,
    "Some problems in interval estimation", Journal of the Royal Statistical Society B 16, 1954).

    Args:
        first: Losses of attacks of one family.
        second: Those of the other, sampled in the same draws.

    Returns:
        Safety times precision, percentage points squared; above zero where the first family's rate
        is the higher one.
    """
    safety, precision = (
        [_mean([getattr(attack, what) for attack in group]) for group in (first, second)]
        for what in ("safety", "precision")
    )
    return Sampled(
        safety[0].value * precision[1].value - safety[1].value * precision[0].value,
        safety[0].samples * precision[1].samples - safety[1].samples * precision[0].samples,
    )


def _families_of(pair: ComparedPair) -> set[str]:
    return {
        family
        for family, names in FAMILIES.items()
        for attack in (pair.first, pair.second)
        if attack.condition.attack in names
    }


def _mean(figures: Sequence[Sampled]) -> Sampled:
    return Sampled(
        float(np.mean([figure.value for figure in figures])),
        np.mean([figure.samples for figure in figures], axis=0),
    )


def _ratio(above: Sampled, below: Sampled) -> Sampled | None:
    """None where the figure that is divided by is not surely above zero."""
    known = below.samples[np.isfinite(below.samples)]
    if not below.value > 0 or not len(known) or (known > 0).mean() < SURELY_ABOVE_ZERO:
        return None
    with np.errstate(invalid="ignore", divide="ignore"):
        drawn = np.where(below.samples > 0, above.samples / below.samples, np.nan)
    return Sampled(above.value / below.value, drawn)
