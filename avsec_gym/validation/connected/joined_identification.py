"""Beyond chapter 3's limit: a car's own evidence joined with that of connected vehicles.

n + 1 sensors of one car name up to n - 2 attacked ones.  What other vehicles see of the car's LiDAR
depends on none of its cameras: given the state vector **s**, their evidence C and the car's own, E,
are independent, and log-likelihoods add up:

    log P(s | E, C) = log P(E | s) + log P(s) + s_0 l(C) - log Z

    l(C) = log P(C | s_0 = 1) - log P(C | s_0 = 0)

C depends on s_0 alone.  But where the others name the LiDAR they also give its scan back, and with
it a witness: E' is what the cameras and the recovered scan show of each other.  Of states with s_0
= 1 the cameras are judged by E', in which the LiDAR counts as sound:

    P(s_0 = 1, s_1 .. s_n | E, E', C) = P(s_0 = 1 | E, C) P(s_1 .. s_n | E', s_0 = 0)

So n - 2 attacked cameras and the LiDAR, n - 1 sensors, are named; of two cameras and a LiDAR, which
by themselves name none, the LiDAR is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.connected.frame_validator import FrameValidator
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.state_posterior import Decoding, SensorStatus, StatePosterior


@dataclass(frozen=True)
class StatusLikelihood:
    """How likely connected vehicles report each status of a LiDAR that is attacked, or is not.

    Args:
        attacked: Instants of an attacked LiDAR by the status that was reported, counted end to end:
            with attacks that no other vehicle sees.
        sound: Instants of a LiDAR without an attack, likewise.

    Raises:
        ConfigurationError: A negative number.

    Example:
        >>> counts = StatusLikelihood({"attacked": 8, "sound": 1}, {"sound": 17})
        >>> counts.ratio(SensorStatus.ATTACKED) > 0 > counts.ratio(SensorStatus.SOUND)
        True
    """

    attacked: Mapping[str, int]
    sound: Mapping[str, int]

    def __post_init__(self) -> None:
        for counts in (self.attacked, self.sound):
            if min(counts.values(), default=0) < 0 or not set(counts) <= set(SensorStatus):
                raise ConfigurationError(
                    f"statuses {', '.join(SensorStatus)} are counted from 0 on, got {dict(counts)}"
                )

    def ratio(self, status: SensorStatus) -> float:
        """l(C), where one more of each status is counted than was seen (Laplace)."""
        return _log_share(self.attacked, status) - _log_share(self.sound, status)


def _log_share(counts: Mapping[str, int], status: SensorStatus) -> float:
    return math.log((counts.get(status, 0) + 1) / (sum(counts.values()) + len(SensorStatus)))


def joined_posterior(
    own: StatePosterior, ratio: float, recovered: StatePosterior | None = None
) -> StatePosterior:
    """P(**s** | E, C), or P(**s** | E, E', C), see the module.

    Args:
        own: P(**s** | E) of N frames by the car's own sensors, S_0 the LiDAR.
        ratio: l(C), the log-likelihood ratio of an attacked LiDAR by connected vehicles.
        recovered: P(**s** | E') of the same frames with the recovered scan; None: there is none.
    """
    of_lidar = own.states[:, 0]
    joined = own.probabilities * np.exp(ratio * of_lidar)
    if recovered is not None:
        # Bit 0 of an index is s_0: each state with it stands right behind the same one without.
        cameras = recovered.probabilities[:, ~of_lidar]
        cameras = cameras / np.maximum(cameras.sum(axis=1, keepdims=True), np.finfo(float).tiny)
        joined[:, of_lidar] = joined[:, of_lidar].sum(axis=1, keepdims=True) * cameras
    return StatePosterior(joined / joined.sum(axis=1, keepdims=True))


def identify_with_neighbours(
    frame: SensorFrame,
    own: LikelihoodValidator,
    others: FrameValidator,
    likelihood: StatusLikelihood,
) -> Decoding:
    """The states of a car's sensors, by these and by connected vehicles.

    Args:
        frame: The car's frame, with what the others share.
        own: The likelihood of the car's own sensors, the LiDAR among them.
        others: The validator by connected vehicles.
        likelihood: What their statuses are worth.

    Returns:
        Of one frame; it alarms where either validator does.

    Raises:
        ConfigurationError: The car's own sensors are without a LiDAR, or are others than the fit's.
        DataError: The frame lacks a sensor, or no other vehicle shares a scan.
    """
    if not own.system.has_lidar:
        raise ConfigurationError("connected vehicles judge a LiDAR, and these sensors have none")
    judged = others.validate(frame)
    alone = own.decode(frame)
    ratio = likelihood.ratio(judged.statuses[LIDAR])
    alarms = alone.alarms | judged.alarm
    if judged.statuses[LIDAR] != SensorStatus.ATTACKED:
        return Decoding(joined_posterior(alone.posterior, ratio), alarms, alone.familiar)
    # With a sound scan in its place, the evidence is again of a kind that the fit knows.
    recovered = own.decode(judged.repaired(frame))
    posterior = joined_posterior(alone.posterior, ratio, recovered.posterior)
    return Decoding(posterior, alarms, recovered.familiar)
