"""A figure with the interval that it is known to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

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
        """Its figure, and the interval beside it, as JSON.

        Example:
            >>> Estimate(0.5, (0.25, 0.75)).columns("rate")
            {'rate': 0.5, 'rate_interval': [0.25, 0.75]}
        """
        interval = None if self.interval is None else list(self.interval)
        return {key: self.value, f"{key}_interval": interval}

    @classmethod
    def of_columns(cls, key: str, columns: Mapping[str, Any]) -> Estimate:
        """The figure and its interval, read back."""
        return cls(columns[key], columns[f"{key}_interval"])


NOTHING = Estimate(None)
