"""Pairs of attacks: does the one that takes more precision take more safety?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from avsec_gym.experiments.chapter5.losses import Losses, LossRow
from avsec_gym.metrics.many_comparisons import holm_findings


@dataclass(frozen=True)
class DiscordantPairs:
    """Pairs of attacks, by whether one takes more of both, see `discordant_pairs`.

    Args:
        pairs: Number of pairs.
        concordant: Number of those of which one surely takes more of both.
        discordant: Number of those of which one surely takes more precision and less safety.
        undecided: Number of those of which neither is sure.
        example: The discordant pair of the largest differences, the one first that takes more
            precision.
    """

    pairs: int
    concordant: int
    discordant: int
    undecided: int
    example: tuple[LossRow, LossRow] | None = None


@dataclass(frozen=True, eq=False)
class ComparedPair:
    """Two attacks, and what one takes more than the other, in percentage points.

    Args:
        first: The attack that takes more precision.
        second: The other one.
        precision: How much more precision the first takes, 0 or more.
        safety: How much more safety the first takes; below 0 where it takes less.
        sure: Whether both differences are surely not zero, see `compared_pairs`.
    """

    first: Losses
    second: Losses
    precision: float
    safety: float
    sure: bool

    @property
    def concordant(self) -> bool:
        """Whether one surely takes more of both."""
        return self.sure and self.precision * self.safety > 0

    @property
    def discordant(self) -> bool:
        """Whether one surely takes more precision and less safety."""
        return self.sure and self.precision * self.safety < 0


def compared_pairs(attacks: Sequence[Losses]) -> list[ComparedPair]:
    """Every pair of attacks, and whether its differences are sure.

    Surely: both differences are not zero, the p-value of which is the larger one of the two
    (Berger 1982, "Multiparameter hypothesis testing and acceptance sampling"), after Holm's
    correction for all pairs given: with a probability of 95 % none is called sure that is not.

    Args:
        attacks: The losses of attacks on one detector.
    """
    pairs = list(combinations(attacks, 2))
    differences = [
        (one.precision - other.precision, one.safety - other.safety) for one, other in pairs
    ]
    sure = holm_findings([np.maximum(taken.p, lost.p) for taken, lost in differences])
    return [
        ComparedPair(one, other, taken.value, lost.value, bool(is_sure))
        if taken.value >= 0
        else ComparedPair(other, one, -taken.value, -lost.value, bool(is_sure))
        for (one, other), (taken, lost), is_sure in zip(pairs, differences, sure, strict=True)
    ]


def discordant_pairs(attacks: Sequence[Losses]) -> DiscordantPairs:
    """Pairs of attacks of which one surely takes more precision, and surely less safety.

    Args:
        attacks: The losses of attacks on one detector; all its pairs are corrected for.
    """
    return counted_pairs(compared_pairs(attacks))


def counted_pairs(pairs: Sequence[ComparedPair]) -> DiscordantPairs:
    """How many of some pairs go which way.

    Args:
        pairs: Some or all of `compared_pairs`: those of a family stay corrected for all.
    """
    against = [pair for pair in pairs if pair.discordant]
    concordant = sum(pair.concordant for pair in pairs)
    example = None
    if against:
        largest = min(against, key=lambda pair: pair.precision * pair.safety)
        example = (largest.first.row, largest.second.row)
    undecided = len(pairs) - concordant - len(against)
    return DiscordantPairs(len(pairs), concordant, len(against), undecided, example)
