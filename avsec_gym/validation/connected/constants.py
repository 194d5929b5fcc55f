"""`ConnectedConstants`: the numbers that connected vehicles decide by."""

from __future__ import annotations

from dataclasses import dataclass, field

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.rays.decision import DecisionRule
from avsec_gym.validation.connected.rays.fitting import ScoreProbability
from avsec_gym.validation.connected.rays.rates import RayRates
from avsec_gym.validation.connected.rays.witness import WitnessMargins
from avsec_gym.validation.connected.surfaces.distance import THESIS_EPSILON

THESIS_THETA = 0.8
"""Metres: most distances of attack-free surfaces lie below it in the thesis, most others above."""

_FARTHEST = 100.0
"""Metres: no two surfaces of one region lie so far apart."""


@dataclass(frozen=True)
class ConnectedConstants:
    """What evidence is worth; a fit measures all of it, see `ConnectedFit`.

    Args:
        rates: Chances of rays.
        margins: How far things may lie apart and still be the same, for rays.
        rule: How evidence of rays becomes a decision.
        epsilon: Mean distance of ground surfaces, metres (equation 4.1).
        theta: Distance beyond which two surfaces are not of one thing, metres.
        of_distance: The calibration from the largest distance of a region to the probability of an
            attack.

    Raises:
        ConfigurationError: An epsilon or theta that is no distance.
    """

    rates: RayRates = field(default_factory=RayRates)
    margins: WitnessMargins = field(default_factory=WitnessMargins)
    rule: DecisionRule = field(default_factory=DecisionRule)
    epsilon: float = THESIS_EPSILON
    theta: float = THESIS_THETA
    of_distance: ScoreProbability = field(
        default_factory=lambda: ScoreProbability(slope=4.0, offset=-4.0 * THESIS_THETA)
    )

    def __post_init__(self) -> None:
        if not (0 <= self.epsilon <= _FARTHEST and -1 <= self.theta <= _FARTHEST):
            raise ConfigurationError(
                f"epsilon and theta are distances, got {self.epsilon} and {self.theta}"
            )
