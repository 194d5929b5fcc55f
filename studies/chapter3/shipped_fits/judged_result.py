"""The result of `judge` as typed rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from avsec_gym.experiments.json_rows import OPTIONAL
from avsec_gym.metrics.clustered_shares import Share


@dataclass(frozen=True)
class JudgedCase:
    """One attacked sensor, or no attack, by one validator.

    Args:
        alarms: Share of frames with an alarm.
        named: Share of frames of which exactly the attacked sensor is named; None: the sensors
            cannot tell.
    """

    alarms: Share
    named: Share | None


@dataclass(frozen=True)
class JudgedSystem:
    """A sensor system by the fits that the package ships for it.

    Args:
        sensors: ``lidar``, and numbers of cameras.
        fitted_on: Data of the fits, in words.
        by: Cases by validator, ``thresholds`` and ``likelihood``, then by attacked sensor.
        clean: Shares of the unattacked frame, by name; None for several frames.
    """

    sensors: Sequence[int | str]
    fitted_on: str
    by: Mapping[str, Mapping[str, JudgedCase]]
    clean: Mapping[str, float] | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class JudgedRealFrames:
    """What real frames and pairs of images show.

    Args:
        draws: Draws of each attack on a frame.
        frames: Systems by the id of their frame.
        thresholds: Shipped thresholds of the four shares, by name.
        pairs: Brightness share of unattacked pairs of images, by id.
    """

    draws: int
    frames: Mapping[str, JudgedSystem]
    thresholds: Mapping[str, float]
    pairs: Mapping[str, float]


@dataclass(frozen=True)
class JudgedFits:
    """All that `judge` measured.

    Args:
        rate: Designated false positive rate r for each triple.
        seed: Seed of the drives.
        frames: Number of procedural frames.
        systems: The judged sensor systems.
        real: Real frames; None where there were none.
    """

    rate: float
    seed: int
    frames: int
    systems: Sequence[JudgedSystem]
    real: JudgedRealFrames | None
