"""What each attack takes: of the precision of a detector, and of driving safety.

All figures are sampled in the same bootstrap draws of scenarios, so that differences and
correlations of them have intervals, too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
from avsec_gym.metrics.average_precision_frames import LEVELS
from avsec_gym.metrics.cluster_bootstrap import ClusterBootstrap, Sampled
from avsec_gym.metrics.estimate import Estimate

_PLACE = (0, METRICS.index("3d"), LEVELS.index("moderate"))
_AP11 = 0
TRUE_ATTACKS = PERTURBATIONS + PATCHES + JOINT_PATCHES
"""Controls, and attacks on changed scenes, are no attacks to compare."""


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
    safe, episodes = safe_by_scenario(outcomes.records(condition), outcomes.scenarios).T
    return ClusterBootstrap(len(outcomes.scenarios), RESAMPLES).ratio(safe, episodes).scaled(100)


def _samples(drawn: Floats | None) -> Floats:
    assert drawn is not None, "precision was asked for with samples"
    return drawn[_PLACE][:, _AP11]
