"""The thesis' claim, tested: are precision and driving safety decoupled?

For every attack: how much of the precision it takes, and how much of safe driving.  If the two went
together, the attack that takes more of one would take more of the other: their rank correlation
measures how far that holds, its interval how certain that is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.stats import rankdata

from avsec_gym.experiments.chapter5.outcomes import (
    RESAMPLES,
    Condition,
    Outcomes,
    safe_by_scenario,
)
from avsec_gym.experiments.chapter5.rows import Estimate, PairedRates
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

_PLACE = (0, METRICS.index("3d"), LEVELS.index("moderate"))
_AP11 = 0
_LOW_AND_HIGH = (0.025, 0.975)
TRUE_ATTACKS = PERTURBATIONS + PATCHES + JOINT_PATCHES
"""Controls, and attacks on changed scenes, are no attacks to compare."""


@dataclass(frozen=True, eq=False)
class Sampled:
    """A figure, and its values in bootstrap samples of scenarios, which all figures share.

    Args:
        value: The figure.
        samples: Its value in each sample, shape (R,); NaN where a sample has nothing to measure.
    """

    value: float
    samples: Floats

    def __sub__(self, other: Sampled) -> Sampled:
        return Sampled(self.value - other.value, self.samples - other.samples)

    @property
    def estimate(self) -> Estimate:
        """The figure with its interval."""
        return Estimate(self.value, self.interval)

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
        precision: The loss of average precision (3D, moderate, 11 points).
        safety: The loss of the safe driving rate over all intentions.
    """

    condition: Condition
    precision: Sampled
    safety: Sampled

    @property
    def row(self) -> LossRow:
        """The losses with their intervals."""
        return LossRow(self.condition, self.precision.estimate, self.safety.estimate)

    @property
    def counts(self) -> bool:
        """Whether it is one of the attacks that the correlation is about."""
        return self.condition.attack in TRUE_ATTACKS and not self.condition.whole_levels


@dataclass(frozen=True)
class LossRow:
    """What one attack takes, in percentage points.

    Args:
        condition: The detector under the attack.
        precision_lost: The loss of average precision.
        safety_lost: The loss of the safe driving rate.
    """

    condition: Condition
    precision_lost: Estimate
    safety_lost: Estimate


@dataclass(frozen=True)
class AttackRow(LossRow):
    """The same with what the correlation makes of it.

    Args:
        counts: Whether it is one of the attacks that the correlation is about.
        paired: The differences of the rates from the unattacked detector.
    """

    counts: bool
    paired: PairedRates | None


@dataclass(frozen=True)
class UnattackedRow:
    """What a detector reaches unattacked, percent.

    Args:
        detector: Its name.
        precision: Average precision.
        safety: Safe driving rate.
    """

    detector: str
    precision: Estimate
    safety: Estimate


@dataclass(frozen=True)
class RankCorrelation:
    """Spearman's, of the loss of precision and that of safety.

    Args:
        attacks: Number of attacks.
        rho: The correlation; None: there is none, see `spearman`.
        interval: Its 95 % interval.
    """

    attacks: int
    rho: float | None
    interval: Sequence[float] | None


@dataclass(frozen=True)
class DiscordantPairs:
    """Pairs of attacks, by whether one takes more of both, see `discordant_pairs`.

    Args:
        pairs: Number of pairs.
        concordant: Number of those of which one surely takes more of both.
        discordant: Number of those of which one surely takes more precision and less safety.
        example: The discordant pair of the largest differences, the one first that takes more
            precision.
    """

    pairs: int
    concordant: int
    discordant: int
    example: tuple[LossRow, LossRow] | None = None


@dataclass(frozen=True)
class Decoupling:
    """The losses under every attack, and how far they go together.

    Args:
        scenarios: Number of scenarios.
        unattacked: A row for each detector.
        attacks: A row for each condition.
        rank_correlation: The rank correlation by detector, and of ``both``.
        discordant_pairs: The pairs of attacks by detector.
    """

    scenarios: int
    unattacked: Sequence[UnattackedRow]
    attacks: Sequence[AttackRow]
    rank_correlation: Mapping[str, RankCorrelation]
    discordant_pairs: Mapping[str, DiscordantPairs]


def decoupling(outcomes: Outcomes) -> Decoupling:
    """The losses under every attack, and how far they go together.

    Correlation and pairs are those of perturbations and patches in float; controls, rounded
    pixels and changed scenes have rows of their own only.
    """
    every = losses(outcomes)
    attacks = [attack for attack in every if attack.counts]
    by_detector = {
        detector: [attack for attack in attacks if attack.condition.detector == detector]
        for detector in dict.fromkeys(attack.condition.detector for attack in attacks)
    }
    return Decoupling(
        scenarios=len(outcomes.scenarios),
        unattacked=[
            UnattackedRow(
                condition.detector,
                precision(outcomes, condition).estimate,
                safety(outcomes, condition).estimate,
            )
            for condition in outcomes.conditions
            if condition.attack == UNATTACKED
        ],
        attacks=[_attack_row(outcomes, attack) for attack in every],
        rank_correlation={
            name: rank_correlation(group)
            for name, group in (*by_detector.items(), ("both", attacks))
        },
        discordant_pairs={name: discordant_pairs(group) for name, group in by_detector.items()},
    )


def losses(outcomes: Outcomes) -> list[Losses]:
    """The losses of every condition but the unattacked, in the order of `Outcomes.conditions`."""
    found = {
        condition: (precision(outcomes, condition), safety(outcomes, condition))
        for condition in outcomes.conditions
    }
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
    value = float(np.mean([precision.ap11[_PLACE] for precision in found]))
    return Sampled(value, np.mean([_samples(precision.drawn) for precision in found], axis=0))


def safety(outcomes: Outcomes, condition: Condition) -> Sampled:
    """Safe driving rate over all intentions, percent, in the same samples as `precision`."""
    samples = draw_resamples(len(outcomes.scenarios), RESAMPLES, 0)
    safe, drives = safe_by_scenario(outcomes.records(condition), outcomes.scenarios).T
    return Sampled(
        100 * float(safe.sum() / drives.sum()), 100 * (samples @ safe) / (samples @ drives)
    )


def rank_correlation(attacks: Sequence[Losses]) -> RankCorrelation:
    """Spearman's, of the loss of precision and that of safety, with its bootstrap interval.

    Each sample draws scenarios, and takes both losses of every attack from the same draw; the
    interval is widened to hold the figure itself.
    """
    rho = spearman([(attack.precision, attack.safety) for attack in attacks])
    if rho is None:
        return RankCorrelation(len(attacks), None, None)
    return RankCorrelation(len(attacks), rho.value, rho.interval_around)


def spearman(pairs: Sequence[tuple[Sampled, Sampled]]) -> Sampled | None:
    """The rank correlation of two figures of several things, in each sample.

    Args:
        pairs: The two figures of each thing.

    Returns:
        The correlation; None for fewer than three things, or where one figure never varies.
    """
    if len(pairs) < 3:
        return None
    drawn = np.array([[figure.samples for figure in pair] for pair in pairs])  # (things, 2, R)
    rho = float(_spearman(np.array([[[figure.value] for figure in pair] for pair in pairs]))[0])
    return Sampled(rho, _spearman(drawn)) if np.isfinite(rho) else None


def discordant_pairs(attacks: Sequence[Losses]) -> DiscordantPairs:
    """Pairs of attacks of which one surely takes more precision, and surely less safety.

    Surely: the 95 % interval of the difference leaves zero out, in both.
    """
    pairs = list(combinations(attacks, 2))
    concordant = discordant = 0
    largest, example = 0.0, None
    for one, other in pairs:
        differences = (one.precision - other.precision, one.safety - other.safety)
        signs = [_sure_sign(difference) for difference in differences]
        concordant += signs[0] * signs[1] > 0
        if signs[0] * signs[1] < 0:
            discordant += 1
            size = abs(differences[0].value * differences[1].value)
            if size > largest:
                first, second = (one, other) if signs[0] > 0 else (other, one)
                largest, example = size, (first.row, second.row)
    return DiscordantPairs(len(pairs), concordant, discordant, example)


def _sure_sign(difference: Sampled) -> int:
    interval = difference.interval
    return 0 if interval is None else int(interval[0] > 0) - int(interval[1] < 0)


def _attack_row(outcomes: Outcomes, attack: Losses) -> AttackRow:
    clean, attacked = (
        outcomes.records(condition) for condition in (attack.condition.unattacked, attack.condition)
    )
    losses = (attack.precision.estimate, attack.safety.estimate)
    return AttackRow(attack.condition, *losses, attack.counts, PairedRates.of(clean, attacked))


def _samples(drawn: Floats | None) -> Floats:
    assert drawn is not None, "precision was asked for with samples"
    return drawn[_PLACE][:, _AP11]


def _spearman(pairs: Floats) -> Floats:
    """Of pairs of shape (n, 2, R), shape (R,); NaN where one of the two does not vary."""
    ranks = rankdata(pairs, axis=0) - (len(pairs) + 1) / 2
    spread = np.sqrt((ranks**2).sum(axis=0))
    with np.errstate(invalid="ignore"):
        return np.asarray((ranks[:, 0] * ranks[:, 1]).sum(axis=0) / (spread[0] * spread[1]))
