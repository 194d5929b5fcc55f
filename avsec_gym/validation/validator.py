"""What a validator is: it looks at one frame and says which sensors are attacked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import Sensor, SensorSystem, Triple
from avsec_gym.validation.state_posterior import SensorStatus

if TYPE_CHECKING:  # OpenCV is loaded where somebody validates, not before.
    from avsec_gym.validation.evidence.disparity_error import DisparityErrors
    from avsec_gym.validation.thresholds import Threshold

SHARES = {
    "error": "E",
    "hole_share": "holes",
    "densest": "densest window",
    "brightness": "other brightness",
}
"""What people call the shares of a `DisparityError`."""
_LEAST = 0.001
"""A threshold below this share of the pixels counts as this one where two are compared."""


@dataclass(frozen=True)
class Exceeded:
    """A share beyond its threshold.

    Args:
        triple: Whose.
        share: Which of `MEASURES`.
        value: How much it is.
        threshold: Beyond which it should not be.
    """

    triple: Triple
    share: str
    value: float
    threshold: float

    @property
    def times(self) -> float:
        """How many times its threshold it is."""
        return self.value / max(self.threshold, _LEAST)


@dataclass(frozen=True, eq=False)
class Validation:
    """What a validator says of one frame.

    Args:
        alarm: Whether an attack is reported.
        statuses: On each sensor of the system.  Without an alarm none is attacked, though some may
            not be told; with it never are all sound.
        errors: What it was concluded from, E_{i,j,k}; its `maps` show where.
        probabilities: That a sensor is attacked, where the validator gives any.
        thresholds: Of each triple, where they are what decides.
    """

    alarm: bool
    statuses: Mapping[Sensor, SensorStatus]
    errors: DisparityErrors
    probabilities: Mapping[Sensor, float] | None = None
    thresholds: Mapping[Triple, Threshold] | None = None

    @property
    def attacked(self) -> frozenset[Sensor]:
        """Sensors that are named as attacked."""
        return frozenset(
            one for one, said in self.statuses.items() if said == SensorStatus.ATTACKED
        )

    @property
    def exceeded(self) -> tuple[Exceeded, ...]:
        """What raised the alarm, where thresholds decide: first what is farthest beyond its own."""
        if self.thresholds is None:
            return ()
        found = [
            Exceeded(triple, share, value, threshold)
            for triple in self.errors.known
            for share, threshold in vars(self.thresholds[triple]).items()
            if (value := getattr(self.errors[triple], share)) > threshold
        ]
        return tuple(sorted(found, key=lambda one: -one.times))


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
        """Judge one frame.

        Raises:
            ConfigurationError: The rig is not the one that the validator was fitted on.
            DataError: The frame lacks a sensor, or its file is broken.
        """
        ...
