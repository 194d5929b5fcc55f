"""Average precision of cars, clean and attacked: what an attack takes, and how surely."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES
from avsec_gym.metrics.average_precision import METRICS, average_precision
from avsec_gym.metrics.average_precision_frames import LEVELS
from avsec_gym.metrics.cluster_bootstrap import Sampled
from avsec_gym.validation.recordings import drive_of

Precisions = dict[str, Sampled]
"""AP by level, in percent at 11 recall points, and of bootstrap samples of drives."""


def car_precision(
    truth: Mapping[str, Boxes3D],
    found: Mapping[str, Boxes3D],
    frames: Sequence[str],
    metric: str,
    least_iou: float,
) -> Precisions:
    """The precision of one detector; bootstrap samples of the same frames are the same.

    Args:
        truth: The labelled boxes, by frame.
        found: The detected boxes, by frame.
        frames: The ids of the judged frames; those of one drive are drawn together, and one drive
            alone gives no interval.
        metric: The metric, one of `METRICS`.
        least_iou: The IoU that a match exceeds.
    """
    result = average_precision(
        [truth[id] for id in frames],
        [found[id] for id in frames],
        classes=["Car"],
        min_iou={"Car": (least_iou, least_iou, least_iou)},
        resamples=RESAMPLES,
        together=[drive_of(id) for id in frames],
    )
    place, drawn = METRICS.index(metric), result.drawn
    assert drawn is not None, "samples were asked for"
    return {
        level: Sampled(float(result.ap11[0, place, column]), drawn[0, place, column, :, 0])
        for column, level in enumerate(LEVELS)
    }


@dataclass(frozen=True)
class PrecisionAtLevel:
    """Average precision of cars at a level of difficulty, percent.

    Args:
        value: The AP.
        interval: The precision's 95 % interval; None of a single drive.
        lost: How much less that is than without the attack.
        lost_interval: The 95 % interval of the loss.
    """

    value: float
    interval: Sequence[float] | None
    lost: float
    lost_interval: Sequence[float] | None


def precision_rows(clean: Precisions, attacked: Precisions) -> dict[str, PrecisionAtLevel]:
    """The precision at each level, and what is lost against clean."""
    rows = {}
    for level, now in attacked.items():
        lost = clean[level] - now
        rows[level] = PrecisionAtLevel(now.value, now.interval, lost.value, lost.interval)
    return rows
