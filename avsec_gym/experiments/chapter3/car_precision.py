"""Average precision of cars, clean and attacked: what an attack takes, and how surely."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.shares import drive_of
from avsec_gym.experiments.chapter5.decoupling import Sampled
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES
from avsec_gym.metrics.average_precision import METRICS
from avsec_gym.metrics.average_precision_curves import (
    average_precisions,
    draw_resamples,
    precision_at_recalls,
    resampled,
)
from avsec_gym.metrics.average_precision_frames import (
    COUNTED,
    LEVELS,
    detection_status,
    label_status,
    pooled,
)
from avsec_gym.metrics.average_precision_matching import match, overlaps

Precisions = dict[str, Sampled]
"""By level: AP in percent at 11 recall points, and of bootstrap samples of drives."""

_CAR = "Car"
_AP11 = 0


def car_precision(
    truth: Mapping[str, Boxes3D],
    found: Mapping[str, Boxes3D],
    moments: Sequence[str],
    metric: str,
    least_iou: float,
) -> Precisions:
    """Of one detector; of the same moments, the bootstrap samples are the same.

    Where `average_precision` draws frames, here drives are drawn, with all their moments.

    Args:
        truth: By moment.
        found: By moment.
        moments: That are judged.
        metric: One of `METRICS`, but for ``aos``.
        least_iou: A match needs more.
    """
    labels = pooled([truth[one] for one in moments], "labels")
    cars = pooled([found[one] for one in moments], "detections")
    common, place = overlaps(labels, cars), METRICS.index(metric)
    names, drive = np.unique([drive_of(one) for one in moments], return_inverse=True)
    samples = draw_resamples(len(names), RESAMPLES, 0)[:, drive]
    result = {}
    for level, name in enumerate(LEVELS):
        wanted, given = label_status(labels, _CAR, level), detection_status(cars, _CAR, level)
        counted = np.bincount(labels.frame[wanted == COUNTED], minlength=len(moments))
        events = match(labels, cars, common, wanted, given, place, least_iou)
        value = average_precisions(precision_at_recalls(events, counted))[0, _AP11]
        drawn = resampled(events, counted, samples)[:, 0, _AP11]
        if len(names) == 1:  # One drive says nothing of others.
            drawn = np.full(RESAMPLES, np.nan)
        result[name] = Sampled(float(value), drawn)
    return result


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
