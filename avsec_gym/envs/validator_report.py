"""What a validator reports to an attacker: whether there is an alarm, and how near it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from avsec_gym.geometry import Floats

if TYPE_CHECKING:  # OpenCV is loaded with the validator, not before.
    from avsec_gym.validation.validator import Judgement

MEASURES = ("error", "hole_share", "densest", "brightness")
"""See `avsec_gym.validation.evidence.disparity_error.DisparityError`."""


@dataclass(frozen=True, eq=False)
class ValidatorReport:
    """What a validator reports of one frame.

    Args:
        alarm: Whether it detects an attack.
        shares: The largest value of each of `MEASURES` among the triples of sensors that it
            compared, in [0, 1], shape (4,).
    """

    alarm: bool
    shares: Floats

    @classmethod
    def of(cls, validation: Judgement | None) -> ValidatorReport:
        """The report; without a validator there is no alarm.

        All shares are 0 without one, and by one that does not compare the car's own sensors.
        """
        from avsec_gym.validation.validator import Validation

        nothing = np.zeros(len(MEASURES))
        if not isinstance(validation, Validation):
            return cls(validation is not None and validation.alarm, nothing)
        known = [validation.errors[triple].shares for triple in validation.errors.known]
        return cls(validation.alarm, np.max([nothing, *known], axis=0))

    @property
    def facts(self) -> dict[str, Any]:
        """The report as `info` has it."""
        return {"alarm": self.alarm} | dict(zip(MEASURES, self.shares.tolist(), strict=True))
