"""The result of `real_frames` as typed rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from avsec_gym.experiments.json_rows import OPTIONAL
from avsec_gym.metrics.clustered_shares import Share

Measures = Mapping[str, float | None]
"""Measures by the names of `MEASURES`; None: a threshold that does not matter."""


@dataclass(frozen=True)
class FittedSuite:
    """What the thresholds come from.

    Args:
        suite: Procedural suite.
        frames: Number of its frames.
    """

    suite: str
    frames: int


@dataclass(frozen=True)
class DetectionOnFrame:
    """What the sensors of a real frame detect of attacks on them.

    Args:
        clean: Measures of the unattacked frame.
        false_alarm: Whether the unattacked frame raises an alarm, by criterion.
        cases: Shares of detected attacks by attacked sensors, such as ``S0+S1``, then by criterion.
    """

    clean: Measures
    false_alarm: Mapping[str, bool]
    cases: Mapping[str, Mapping[str, Share]]


@dataclass(frozen=True)
class ScanImpact:
    """What a detector of LiDAR scans is led to see.

    Args:
        score: Least score of a box that counts.
        frames: Ids of the frames.
        taken: Share of bogus returns that are taken for an obstacle.
        already: Share of their places where an obstacle was seen without attack.
        car_taken: Share of pasted cars that are taken for one; the scan of another frame's car
            hides what is behind it.  None: no other frame has a car.
        car_already: Share of their places where one was seen without attack; None as above.
    """

    score: float
    frames: Sequence[str]
    taken: Share
    already: Share
    car_taken: Share | None = field(default=None, metadata=OPTIONAL)
    car_already: Share | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class ImageImpact:
    """What a detector of images sees under a facula.

    Args:
        score: Least score of a box that counts.
        frames: Ids of the frames.
        found: Share of the moderate cars that are found without attack.
        found_attacked: Share of them that are found under a facula.
        false_alarms: False alarms an image without attack.
        false_alarms_attacked: False alarms an image under a facula.
    """

    score: float
    frames: Sequence[str]
    found: Share
    found_attacked: Share
    false_alarms: float
    false_alarms_attacked: float


@dataclass(frozen=True)
class DetectorImpacts:
    """What each detector sees; None: no labelled frame has what it looks at."""

    pixor: ScanImpact | None
    pointrcnn: ScanImpact | None
    faster_rcnn: ImageImpact | None
    yolo: ImageImpact | None


@dataclass(frozen=True)
class RealFramesResult:
    """All that `real_frames` measured.

    Args:
        fitted: What the thresholds come from.
        rate: Designated false positive rate r.
        draws: Draws of each attack on every frame.
        thresholds: Thresholds by criterion.
        frames: What is detected, by the id of the frame.
        impact: What detectors are led to see.
    """

    fitted: FittedSuite
    rate: float
    draws: int
    thresholds: Mapping[str, Measures]
    frames: Mapping[str, DetectionOnFrame]
    impact: DetectorImpacts
