"""What a validator is: it judges one frame and reports the status of each sensor."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import Sensor, SensorSystem, Triple
from avsec_gym.validation.state_posterior import SensorStatus

if TYPE_CHECKING:  # OpenCV is loaded where frames are validated, not before.
    from avsec_gym.validation.evidence.disparity_error import DisparityErrors
    from avsec_gym.validation.thresholds import Threshold

SHARES = {
    "error": "E",
    "hole_share": "holes",
    "densest": "densest window",
    "brightness": "other brightness",
}
"""Names of the shares of a `DisparityError` in words."""
_LEAST = 0.001
"""A threshold below this share of the pixels counts as this one where two are compared."""


@dataclass(frozen=True)
class Exceeded:
    """A share beyond its threshold.

    Args:
        triple: The triple of sensors.
        share: The measure, one of `MEASURES`.
        value: The value of the share.
        threshold: The threshold that the value exceeds.
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
class Judgement:
    """What any validator makes of a frame, and a car needs to go on.

    Args:
        alarm: Whether an attack is reported.
        statuses: The status of each sensor that was judged.  Without an alarm none is attacked,
            though some may be open; with an alarm never are all sound.
    """

    alarm: bool
    statuses: Mapping[Sensor, SensorStatus]

    @property
    def attacked(self) -> frozenset[Sensor]:
        """Sensors that are named as attacked."""
        return frozenset(
            sensor for sensor, status in self.statuses.items() if status == SensorStatus.ATTACKED
        )


class RepairingJudgement(Judgement, ABC):
    """One that holds itself what takes the place of compromised data."""

    @abstractmethod
    def repaired(self, frame: SensorFrame) -> SensorFrame:
        """The frame with the data of compromised sensors repaired, as far as the rest allows.

        Args:
            frame: The frame that was judged.

        Returns:
            A frame that raises `Untrusted` when it is asked for what nothing can replace.
        """


@dataclass(frozen=True, eq=False)
class Validation(Judgement):
    """The result of a validator that compares the sensors of one car in one frame.

    Args:
        alarm: Whether an attack is reported.
        statuses: The status of each sensor of the system.  Without an alarm none is attacked,
            though some may be open; with an alarm never are all sound.
        errors: The errors E_{i,j,k} that decided; their `maps` show where.
        probabilities: P(attacked) of each sensor, where the validator gives any.
        thresholds: The thresholds of each triple, where thresholds decide.
    """

    errors: DisparityErrors
    probabilities: Mapping[Sensor, float] | None = None
    thresholds: Mapping[Triple, Threshold] | None = None

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
    """Anything that judges the sensors of a system by the evidence that they give of each other."""

    @property
    def name(self) -> str:
        """The name of the validator."""
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
