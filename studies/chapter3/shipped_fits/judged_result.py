"""The result of `judge` as typed rows, read from its JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

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
        clean: Shares of the unattacked frame, by name; empty for several frames.
    """

    sensors: Sequence[str]
    fitted_on: str
    by: Mapping[str, Mapping[str, JudgedCase]]
    clean: Mapping[str, float]

    @classmethod
    def of(cls, system: Mapping[str, Any]) -> JudgedSystem:
        """The rows of a system as JSON has it."""
        by = {
            name: {
                case: JudgedCase(
                    Share(**judged["alarms"]), Share(**judged["named"]) if judged["named"] else None
                )
                for case, judged in cases.items()
            }
            for name, cases in system["by"].items()
        }
        return cls(system["sensors"], system["fitted_on"], by, system.get("clean", {}))


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

    @classmethod
    def of(cls, real: Mapping[str, Any]) -> JudgedRealFrames:
        """The rows as JSON has them."""
        frames = {id: JudgedSystem.of(system) for id, system in real["frames"].items()}
        return cls(real["draws"], frames, real["thresholds"], real["pairs"])


@dataclass(frozen=True)
class JudgedFits:
    """All that `judge` measured.

    Args:
        rate: Designated false positive rate r for each triple.
        frames: Number of procedural frames.
        seed: Seed of their drives.
        systems: The judged sensor systems.
        real: Real frames; None where there were none.
    """

    rate: float
    frames: int
    seed: int
    systems: Sequence[JudgedSystem]
    real: JudgedRealFrames | None

    @classmethod
    def of(cls, result: Mapping[str, Any]) -> JudgedFits:
        """The rows of a result as JSON has it.

        Raises:
            KeyError: A part is missing.
            TypeError: A part has another form.
        """
        return cls(
            rate=result["rate"],
            frames=result["frames"],
            seed=result["seed"],
            systems=[JudgedSystem.of(system) for system in result["systems"]],
            real=None if result["real"] is None else JudgedRealFrames.of(result["real"]),
        )
