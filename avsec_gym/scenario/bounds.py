"""Which numbers a planning problem may hold: finite ones that roads and vehicles can have."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

import numpy as np

from avsec_gym.argument_checks import shown
from avsec_gym.errors import PlanningError


@dataclass(frozen=True)
class Bounds:
    """An interval that a quantity lies in, both ends included."""

    low: float
    high: float
    unit: str = ""
    whole: bool = False
    """Whether only whole numbers are meant."""

    def check(self, value: float, what: str) -> None:
        """Refuse a number that does not lie within.

        Args:
            value: The number.
            what: Place of the number, for the message.

        Raises:
            PlanningError: It is no number, not finite, or outside.
        """
        # Arrays are none: numpy's and Python's own numbers are, and most are of one kind.
        usual, kind = (int, Integral) if self.whole else (float, Real)
        fits = type(value) is usual or isinstance(value, kind)
        if not fits or not self.low <= value <= self.high:  # Also true for NaN.
            raise PlanningError(f"{what} is {shown(value)}; expected {self}.")

    def check_all(self, values: Any, what: str) -> None:
        """Refuse numbers of which any does not lie within.

        Raises:
            PlanningError: One is no number, not finite, or outside.
        """
        try:
            array = np.asarray(values)
        except ValueError:  # Lists of several lengths.
            array = np.array(None)
        if array.dtype.kind not in ("biu" if self.whole else "biuf"):
            raise PlanningError(f"{what} is no number: {shown(values)}; expected {self}.")
        within = (array >= self.low) & (array <= self.high)
        if not within.all():
            self.check(array[~within].flat[0].item(), what)

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        return f"a {'whole ' if self.whole else ''}number from {self.low:g} to {self.high:g}{unit}"


COORDINATE = Bounds(-3e7, 3e7, "m")
"""Maps may count from a far origin: web Mercator, the widest, ends 2.0e7 m from the equator."""
SIZE = Bounds(1e-9, 1e5, "m")
ANGLE = Bounds(-1e3, 1e3, "rad")
SPEED = Bounds(-1e3, 1e3, "m/s")
TIME_STEP = Bounds(0, 100_000, whole=True)
DURATION = Bounds(1e-6, 10.0, "s")
