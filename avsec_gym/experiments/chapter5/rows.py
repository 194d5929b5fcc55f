"""What the rows of chapter 5's tables share: figures with intervals, paired tests, and their JSON.

Each row is a dataclass beside the function that makes it.  In JSON it is flat: the columns of its
`Condition` and of its rates stand among its own, and the interval of an `Estimate` beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass

from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord

Interval = Sequence[float]
"""Low and high."""


@dataclass(frozen=True)
class Estimate:
    """A figure with its 95 % interval.

    Args:
        value: The figure; None: there is nothing to measure.
        interval: Its interval; None: it cannot be drawn.
    """

    value: float | None
    interval: Interval | None = None


NOTHING = Estimate(None)
FLAT = {"flat": True}
"""Metadata of a field whose columns stand among those of the row."""


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


def keyed(key: str) -> Mapping[str, str]:
    """Metadata of a field whose key in JSON is no name in Python."""
    return {"key": key}


def row_json(row: object) -> dict[str, object]:
    """A row as flat JSON.

    Args:
        row: A dataclass.

    Example:
        >>> from avsec_gym.experiments.chapter5.seen import SeenRow
        >>> found = Estimate(0.5, (0.25, 0.75))
        >>> row_json(SeenRow(Condition("dsgn"), found, NOTHING, NOTHING))["cars_found_interval"]
        [0.25, 0.75]
    """
    assert is_dataclass(row)
    columns: dict[str, object] = {}
    for column in fields(row):
        key, value = column.metadata.get("key", column.name), getattr(row, column.name)
        columns |= _columns(key, value, flat="flat" in column.metadata)
    return columns


def as_json(value: object) -> object:
    """The JSON of rows in lists and mappings."""
    if is_dataclass(value):
        return row_json(value)
    if isinstance(value, Mapping):
        return {str(key): as_json(item) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [as_json(item) for item in value]
    return value


def _columns(key: str, value: object, *, flat: bool) -> dict[str, object]:
    """The columns that a field makes."""
    if isinstance(value, Estimate):
        return {key: value.value, f"{key}_interval": as_json(value.interval)}
    if isinstance(value, SafetyRates):
        return value.to_json()
    if flat and value is None:
        return {}
    if flat and isinstance(value, Mapping):
        return {
            name: number
            for inner, item in value.items()
            for name, number in _columns(inner, item, flat=False).items()
        }
    return row_json(value) if flat or isinstance(value, Condition) else {key: as_json(value)}
