"""What a validator is: it looks at one moment and says which sensors are attacked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import Sensor, SensorSystem
from avsec_gym.validation.state_posterior import Verdict

if TYPE_CHECKING:  # OpenCV is loaded where somebody validates, not before.
    from avsec_gym.validation.disparity_error import DisparityErrors


@dataclass(frozen=True, eq=False)
class Validation:
    """What a validator says of one moment.

    Args:
        alarm: Whether an attack is reported.
        verdicts: On each sensor of the system.  Without an alarm none is attacked, though some may
            not be told; with it never are all sound.
        errors: What it was concluded from, E_{i,j,k}; its `maps` show where.
        probabilities: That a sensor is attacked, where the validator gives any.
    """

    alarm: bool
    verdicts: Mapping[Sensor, Verdict]
    errors: DisparityErrors
    probabilities: Mapping[Sensor, float] | None = None

    @property
    def attacked(self) -> frozenset[Sensor]:
        """Sensors that are named as attacked."""
        return frozenset(one for one, said in self.verdicts.items() if said == Verdict.ATTACKED)


@runtime_checkable
class Validator(Protocol):
    """Anything that judges the sensors of a system by what they say of each other."""

    @property
    def name(self) -> str:
        """How it is called."""
        ...

    @property
    def system(self) -> SensorSystem:
        """The sensors that it judges."""
        ...

    def validate(self, frame: SensorFrame) -> Validation:
        """Judge one moment.

        Raises:
            ConfigurationError: The rig is not the one that the validator was fitted on.
            DataError: The frame lacks a sensor, or its file is broken.
        """
        ...
