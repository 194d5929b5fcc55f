"""What a car does about a validator's alarm."""

from __future__ import annotations

from enum import StrEnum

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.suggestions import unknown_name
from avsec_gym.validation.compromised_sensors import (
    Untrusted,
    with_compromised_sensors_repaired,
    without_compromised_sensors,
)
from avsec_gym.validation.validator import Judgement, RepairingJudgement, Validation


class Response(StrEnum):
    """The ways to go on, or not to."""

    STOP = "stop"
    """The car brakes until it stands (`avsec_gym.emergency_stop`)."""
    DROP = "drop"
    """The car drives on without the compromised sensors, through another pair of cameras if need
    be, and stops where that is impossible (`without_compromised_sensors`)."""
    REPAIR = "repair"
    """The car drives on with the data of compromised sensors repaired by the others, and stops
    where these are too few (`with_compromised_sensors_repaired`); or, by connected vehicles, with
    the scan that these give back (`recovered_scan`)."""

    @classmethod
    def named(cls, name: Response | str) -> Response:
        """The one of that name.

        Raises:
            ConfigurationError: There is none.
        """
        try:
            return cls(name)
        except ValueError:
            problem = f"{name!r} is no response to an alarm"
            raise ConfigurationError(unknown_name(problem, str(name), cls)) from None


def trusted_frame(frame: SensorFrame, validation: Judgement, response: Response) -> SensorFrame:
    """The frame that detectors get; without an alarm the whole frame.

    Args:
        frame: The frame that the validator judged.
        validation: The result of that validator.
        response: The response to an alarm.

    Raises:
        Untrusted: The car stops.  The frame itself may raise it later, when it is asked for data
            that nothing can replace.
    """
    if not validation.alarm:
        return frame
    if response == Response.STOP:
        raise Untrusted(f"Frame {frame.id}: there is an alarm.", path=frame.origin)
    if response == Response.REPAIR and isinstance(validation, RepairingJudgement):
        return validation.repaired(frame)
    if response == Response.REPAIR and isinstance(validation, Validation):
        return with_compromised_sensors_repaired(frame, validation)
    return without_compromised_sensors(frame, validation)
