"""The decision from all testimonies: which regions are attacked, and which vehicle's LiDAR was."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number, whole_number
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.fitting import ScoreProbability
from avsec_gym.validation.connected.rays.rates import RayRates, decidable, log_likelihood_ratio

CANNOT_TELL = -1
"""An attack of which the rays do not show whose LiDAR it was, or too few vehicles do."""
NO_ATTACK = -2
_ACCUSERS = 2
"""Independent vehicles that name a third, before liars are reckoned with (`upheld_by_rays`)."""


@dataclass(frozen=True)
class DecisionRule:
    """How evidence becomes a decision.

    Args:
        alarm: Probability from which a region counts as attacked.
        certain: Probability, if there is an attack, from which its victim is named.
        accuser: Log-likelihood ratio from which a vehicle is one of those that accuse.
        see_through: Log odds of a thing that rays see through, such as a fence or a hedge, to an
            attack, where both explain the same.
        calibration: The calibration from a region's score to the probability of an attack.
        liars: Number of vehicles that are reckoned with to lie: so many accusers more name a
            victim, of whom two accuse clearly.

    Raises:
        ConfigurationError: A probability that is none, or no number of liars.
    """

    alarm: float = 0.5
    certain: float = 0.9
    accuser: float = 1.0
    see_through: float = -1.0
    calibration: ScoreProbability = field(default_factory=ScoreProbability)
    liars: int = 0

    def __post_init__(self) -> None:
        whole_number("liars", self.liars, 0)
        if not (0 < self.alarm < 1 and 0.5 <= self.certain < 1 and self.accuser > 0):
            raise ConfigurationError(
                "probabilities of a decision lie between 0 and 1, certainty is 0.5 or more, and"
                f" accusers have a positive ratio; got {self}"
            )
        number("see_through", self.see_through, -1e6, 1e6)


@dataclass(frozen=True, eq=False)
class Decision:
    """What is decided about the regions of an instant.

    Args:
        score: Log-likelihood ratio of the best explanation by an attack on one vehicle, shape
            (R,); -inf where no testimony decides anything.
        probability: Probability of an attack, shape (R,).
        ghost: Probability, if there is an attack, of a ghost in each vehicle's scan, shape (R, V).
        removal: Probability, if there is an attack, of an object removed from each vehicle's
            scan, shape (R, V).
        named: The victim, `CANNOT_TELL` or `NO_ATTACK`, shape (R,).
    """

    score: Floats
    probability: Floats
    ghost: Floats
    removal: Floats
    named: NDArray[np.int64]

    @property
    def victim(self) -> Floats:
        """Probability, if there is an attack, that each vehicle is its victim, shape (R, V)."""
        return self.ghost + self.removal


def decide(counts: NDArray[np.int64], rates: RayRates, rule: DecisionRule) -> Decision:
    """Weigh all explanations of what vehicles claim and see in each region.

    A ghost in the scan of ``j`` contradicts all witnesses of what ``j`` claims.  An object removed
    from the scan of ``k`` makes ``k`` contradict all claims of others.  A thing that rays see
    through contradicts in all directions.  Each explanation's evidence is the sum over the pairs
    of vehicles that it touches; the others are equally likely under all of them.

    It is assumed that one vehicle is attacked in each region.  With two, each is the victim of an
    explanation that half of the evidence speaks against, and the answer is `CANNOT_TELL`.

    Args:
        counts: Counts of what witness ``k`` reports of the claim of ``j``, shape (R, V, V, 3), 0
            where it reports nothing.
        rates: The chances of rays.
        rule: How evidence becomes a decision.
    """
    vehicles = counts.shape[1]
    others = ~np.eye(vehicles, dtype=bool)
    decided = decidable(counts, rates) & others
    ratio = np.where(decided, log_likelihood_ratio(counts, rates), 0.0)
    # Explanations, with evidence or out of the question: a ghost in each scan, a removal from each.
    ghost = np.where(decided.any(axis=2), ratio.sum(axis=2), -np.inf)
    removal = np.where(decided.any(axis=1), ratio.sum(axis=1), -np.inf)
    attack = np.concatenate([ghost, removal], axis=1)
    best = attack.max(axis=1)
    # What rays see through explains the contradictions of all pairs at once.
    more = np.maximum(ratio.sum(axis=(1, 2)) + rule.see_through - np.maximum(best, 0), 0)
    score = best - more
    some = decided.any(axis=(1, 2))
    # A region of which nothing is known does not alarm.
    probability = np.where(some, rule.calibration.probability(np.where(some, score, 0.0)), 0.0)
    share = np.exp(attack - np.where(some, best, 0.0)[:, None])
    share /= np.maximum(share.sum(axis=1, keepdims=True), 1.0)
    ghosts, removals = share[:, :vehicles], share[:, vehicles:]
    # A victim has a sufficient share of the probability, and two accusers.
    accused = decided & (ratio >= rule.accuser)
    accusers = np.where(ghosts >= removals, accused.sum(axis=2), accused.sum(axis=1))
    victim = (ghosts + removals).argmax(axis=1)
    rows = np.arange(len(victim))
    clear = (ghosts + removals)[rows, victim] >= rule.certain
    clear &= accusers[rows, victim] >= _ACCUSERS
    named = np.where(probability >= rule.alarm, np.where(clear, victim, CANNOT_TELL), NO_ATTACK)
    return Decision(score, probability, ghosts, removals, named)
