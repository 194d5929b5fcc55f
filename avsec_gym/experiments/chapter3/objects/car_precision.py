"""Average precision of cars, clean and attacked: what an attack takes, and how surely."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.decoupling import Sampled
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES
from avsec_gym.metrics.average_precision import METRICS, average_precision
from avsec_gym.metrics.average_precision_frames import LEVELS
from avsec_gym.validation.recordings import drive_of

Precisions = dict[str, Sampled]
"""By level: AP in percent at 11 recall points, and of bootstrap samples of drives."""


def car_precision(
    truth: Mapping[str, Boxes3D],
    found: Mapping[str, Boxes3D],
    frames: Sequence[str],
    metric: str,
    least_iou: float,
) -> Precisions:
    """Of one detector; of the same frames, the bootstrap samples are the same.

    Args:
        truth: The labelled boxes, by frame.
        found: The detected boxes, by frame.
        frames: The ids of the judged frames; those of one drive are drawn together, and one drive
            alone gives no interval.
        metric: The metric, one of `METRICS`.
        least_iou: The IoU that a match exceeds.
    """
    drives = [drive_of(id) for id in frames]
    result = average_precision(
        [truth[id] for id in frames],
        [found[id] for id in frames],
        classes=["Car"],
        min_iou={"Car": (least_iou, least_iou, least_iou)},
        resamples=RESAMPLES,
        together=drives,
    )
    place, drawn = METRICS.index(metric), result.drawn
    assert drawn is not None, "samples were asked for"
    alone = len(set(drives)) == 1
    return {
        level: Sampled(
            float(result.ap11[0, place, column]),
            np.full(RESAMPLES, np.nan) if alone else drawn[0, place, column, :, 0],
        )
        for column, level in enumerate(LEVELS)
    }


def precision_rows(clean: Precisions, attacked: Precisions) -> dict[str, Any]:
    """For each level ``value``, and ``lost`` against clean, with 95 % intervals; percent."""
    rows = {}
    for level, now in attacked.items():
        lost = clean[level] - now
        rows[level] = {
            "value": now.value,
            "interval": now.interval,
            "lost": lost.value,
            "lost_interval": lost.interval,
        }
    return rows
