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


def discordant_pairs(attacks: Sequence[Losses]) -> DiscordantPairs:
    """Pairs of attacks of which one surely takes more precision, and surely less safety.

    Surely: both differences are not zero, the p-value of which is the larger one of the two
    (Berger 1982, "Multiparameter hypothesis testing and acceptance sampling"), after Holm's
    correction for all pairs of the detector: with a probability of 95 % none is called sure that is
    not.
    """
    pairs = list(combinations(attacks, 2))
    differences = [
        (one.precision - other.precision, one.safety - other.safety) for one, other in pairs
    ]
    sure = holm_findings([np.maximum(taken.p, lost.p) for taken, lost in differences])
    products = np.array([taken.value * lost.value for taken, lost in differences])
    concordant, discordant = (int((sure & (sign * products > 0)).sum()) for sign in (1, -1))
    example = None
    if discordant:
        largest = int(np.argmin(np.where(sure, products, 0.0)))
        first, second = pairs[largest]
        if differences[largest][0].value < 0:
            first, second = second, first
        example = (first.row, second.row)
    undecided = len(pairs) - concordant - discordant
    return DiscordantPairs(len(pairs), concordant, discordant, undecided, example)
