"""The thesis' claim, tested: are precision and driving safety decoupled?

For every attack: how much of the precision it takes, and how much of safe driving.  If the two went
together, the attack that takes more of one would take more of the other: their rank correlation
measures how far that holds, its interval how certain that is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avsec_gym.experiments.chapter5.losses import (
    Losses,
    LossRow,
    losses,
    precision,
    safety,
)
from avsec_gym.experiments.chapter5.outcomes import Outcomes
from avsec_gym.experiments.chapter5.pairs_of_attacks import DiscordantPairs, discordant_pairs
from avsec_gym.experiments.chapter5.settings import UNATTACKED
from avsec_gym.metrics.cluster_bootstrap import sampled_rank_correlation
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.paired import PairedRates, paired_differences


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
        detector: The detector's name.
        precision: Average precision.
        safety: Safe driving rate.
    """

    detector: str
    precision: Estimate
    safety: Estimate


@dataclass(frozen=True)
class RankCorrelation:
    """Spearman's correlation of the loss of precision with that of safety.

    Args:
        attacks: Number of attacks.
        rho: The correlation; None: there is none, see
            `sampled_rank_correlation`.
        interval: The correlation's 95 % interval.
    """

    attacks: int
    rho: float | None
    interval: Sequence[float] | None


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
        attacks=[attack_row(outcomes, attack) for attack in every],
        rank_correlation={
            name: rank_correlation(group)
            for name, group in (*by_detector.items(), ("both", attacks))
        },
        discordant_pairs={name: discordant_pairs(group) for name, group in by_detector.items()},
    )


def rank_correlation(attacks: Sequence[Losses]) -> RankCorrelation:
    """Spearman's correlation of the losses of precision and safety, with its bootstrap interval.

    Each sample draws scenarios, and takes both losses of every attack from the same draw; the
    interval is widened to hold the figure itself.
    """
    rho = sampled_rank_correlation([(attack.precision, attack.safety) for attack in attacks])
    if rho is None:
        return RankCorrelation(len(attacks), None, None)
    return RankCorrelation(len(attacks), rho.value, rho.interval_around)


def attack_row(outcomes: Outcomes, attack: Losses) -> AttackRow:
    """The losses under one attack, with the differences of the rates from the unattacked detector.

    Args:
        outcomes: The outcomes that the losses were measured on.
        attack: The losses.
    """
    clean, attacked = (
        outcomes.records(condition) for condition in (attack.condition.unattacked, attack.condition)
    )
    losses = (attack.precision.estimate, attack.safety.estimate)
    return AttackRow(attack.condition, *losses, attack.counts, paired_differences(clean, attacked))
