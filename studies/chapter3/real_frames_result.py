"""The result of `real_frames` as typed rows, read from its JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from avsec_gym.metrics.clustered_shares import Share
from studies.chapter3.real_impact import IMAGE_DETECTORS, LIDAR_DETECTORS


@dataclass(frozen=True)
class DetectionOnFrame:
    """What the sensors of a real frame detect of attacks on them.

    Args:
        cases: Shares of detected attacks by attacked sensors, such as ``S0+S1``, then by criterion.
        false_alarm: Whether the unattacked frame raises an alarm, by criterion.
    """

    cases: Mapping[str, Mapping[str, Share]]
    false_alarm: Mapping[str, bool]


@dataclass(frozen=True)
class ScanImpact:
    """What a detector of LiDAR scans is led to see.

    Args:
        frames: Number of frames.
        taken: Share of bogus returns that are taken for an obstacle.
        already: Share of their places where an obstacle was seen without attack.
        car_taken: Share of pasted cars that are taken for one; None: not measured.
        car_already: Share of their places where one was seen without attack; None: not measured.
    """

    frames: int
    taken: Share
    already: Share
    car_taken: Share | None
    car_already: Share | None


@dataclass(frozen=True)
class ImageImpact:
    """What a detector of images sees under a facula.

    Args:
        frames: Number of frames.
        found: Share of the moderate cars that are found without attack.
        found_attacked: Share of them that are found under a facula.
        false_alarms: False alarms an image without attack.
        false_alarms_attacked: False alarms an image under a facula.
    """

    frames: int
    found: Share
    found_attacked: Share
    false_alarms: float
    false_alarms_attacked: float


@dataclass(frozen=True)
class RealFramesResult:
    """All that `real_frames` measured.

    Args:
        rate: Designated false positive rate r.
        draws: Draws of each attack on every frame.
        suite: Procedural suite that the thresholds come from.
        fitted_frames: Number of its frames.
        frames: What is detected, by the id of the frame.
        scans: Impact by detector of scans; those that could not be judged are absent.
        images: Impact by detector of images; those that could not be judged are absent.
    """

    rate: float
    draws: int
    suite: str
    fitted_frames: int
    frames: Mapping[str, DetectionOnFrame]
    scans: Mapping[str, ScanImpact]
    images: Mapping[str, ImageImpact]

    @classmethod
    def of(cls, result: Mapping[str, Any]) -> RealFramesResult:
        """The rows of a result as JSON has it.

        Raises:
            KeyError: A part is missing.
            TypeError: A part has another form.
        """
        impact, fitted = result["impact"], result["fitted"]
        return cls(
            rate=result["rate"],
            draws=result["draws"],
            suite=fitted["suite"],
            fitted_frames=fitted["frames"],
            frames={id: _detection(found) for id, found in result["frames"].items()},
            scans={name: _scans(impact[name]) for name in LIDAR_DETECTORS if impact[name]},
            images={name: _images(impact[name]) for name in IMAGE_DETECTORS if impact[name]},
        )


def _detection(found: Mapping[str, Any]) -> DetectionOnFrame:
    cases = {
        case: {criterion: Share(**share) for criterion, share in shares.items()}
        for case, shares in found["cases"].items()
    }
    return DetectionOnFrame(cases, found["false_alarm"])


def _scans(found: Mapping[str, Any]) -> ScanImpact:
    return ScanImpact(
        frames=len(found["frames"]),
        taken=Share(**found["taken"]),
        already=Share(**found["already"]),
        car_taken=Share(**found["car_taken"]) if "car_taken" in found else None,
        car_already=Share(**found["car_already"]) if "car_already" in found else None,
    )


def _images(found: Mapping[str, Any]) -> ImageImpact:
    return ImageImpact(
        frames=len(found["frames"]),
        found=Share(**found["found"]),
        found_attacked=Share(**found["found_attacked"]),
        false_alarms=found["false_alarms"],
        false_alarms_attacked=found["false_alarms_attacked"],
    )
