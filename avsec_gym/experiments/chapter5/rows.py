"""What the rows of chapter 5's tables share: figures with intervals, and paired tests.

Each row is a dataclass beside the function that makes it.  In JSON (`json_rows`) it is flat: the
columns of its `Condition` and of its rates stand among its own, and the interval of an `Estimate`
beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from avsec_gym.experiments.json_rows import as_json
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRecord

Interval = Sequence[float]
"""Low and high."""


@dataclass(frozen=True)
class Estimate:
    """A figure with its 95 % interval.

    Args:
        value: The figure; None: there is nothing to measure.
        interval: The interval of the estimate; None: it cannot be drawn.
    """

    value: float | None
    interval: Interval | None = None

    def columns(self, key: str) -> dict[str, object]:
        """Its figure, and the interval beside it; see `json_rows`.

        Example:
            >>> Estimate(0.5, (0.25, 0.75)).columns("rate")
            {'rate': 0.5, 'rate_interval': [0.25, 0.75]}
        """
        return {key: self.value, f"{key}_interval": as_json(self.interval)}

    @classmethod
    def of_columns(cls, key: str, columns: Mapping[str, Any]) -> Estimate:
        """The figure and its interval, read back."""
        return cls(columns[key], columns[f"{key}_interval"])


NOTHING = Estimate(None)


@dataclass(frozen=True)
class PairedRates:
    """How rates differ between two inputs on the same scenarios; see `paired_differences`.

    Args:
        scenarios: Number of scenarios.
        drives: Number of episodes.
        success_rate: Difference of the success rate.
        collision_rate: Difference of the collision rate.
        safe_driving_rate: Difference of the safe driving rate.
        became_unsafe: Number of episodes that were safe and are not.
        became_safe: Number of episodes that were not safe and are.
        mcnemar_p: McNemar's exact test; None where a scenario has several episodes.
    """

    scenarios: int
    drives: int
    success_rate: Estimate
    collision_rate: Estimate
    safe_driving_rate: Estimate
    became_unsafe: int
    became_safe: int
    mcnemar_p: float | None

    @classmethod
    def of(
        cls, before: Sequence[SafetyRecord], after: Sequence[SafetyRecord]
    ) -> PairedRates | None:
        """Those of two inputs; None without episodes."""
        if not before:
            return None
        found = paired_differences(before, after)
        success, collision, safe = (
            Estimate(found[rate], found[f"{rate}_interval"])
            for rate in ("success_rate", "collision_rate", "safe_driving_rate")
        )
        return cls(
            scenarios=found["scenarios"],
            drives=found["drives"],
            success_rate=success,
            collision_rate=collision,
            safe_driving_rate=safe,
            became_unsafe=found["became_unsafe"],
            became_safe=found["became_safe"],
            mcnemar_p=found["mcnemar_p"],
        )
