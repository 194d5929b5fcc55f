"""What an attacker gets to know of a validator: whether it raises an alarm, and how near it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats

if TYPE_CHECKING:  # OpenCV is loaded where somebody validates, not before.
    from avsec_gym.validation.validator import Validator

MEASURES = ("error", "hole_share", "densest", "brightness")
"""See `avsec_gym.validation.evidence.disparity_error.DisparityError`."""


@dataclass(frozen=True, eq=False)
class Notice:
    """What a validator says of one moment.

    Args:
        alarm: Whether it noticed something.
        shares: Of each of `MEASURES` the largest of the triples that it looked at, in [0, 1],
            shape (4,).
    """

    alarm: bool
    shares: Floats

    @classmethod
    def of(cls, validator: Validator | None, frame: SensorFrame) -> Notice:
        """Let it look; nobody notices nothing."""
        nothing = np.zeros(len(MEASURES))
        if validator is None:
            return cls(False, nothing)
        validation = validator.validate(frame)
        known = [validation.errors[triple].shares for triple in validation.errors.known]
        return cls(validation.alarm, np.max([nothing, *known], axis=0))

    @property
    def facts(self) -> dict[str, Any]:
        """For `info`."""
        return {"noticed": self.alarm} | dict(zip(MEASURES, self.shares.tolist(), strict=True))
