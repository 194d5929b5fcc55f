"""From events to curves: precision at 41 recalls, average precision, and its bootstrap interval."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from avsec_gym.geometry import Floats, Integers
from avsec_gym.kernels import kernel
from avsec_gym.metrics.average_precision_matching import Events

SLOTS = 41
"""Recall 0, 1/40, ..., 1."""
AP11_SLOTS, AP40_SLOTS = slice(0, None, 4), slice(1, None)
"""Recall 0, 0.1, ..., 1 (papers before October 2019); recall 1/40, 2/40, ..., 1 (since then)."""

FEWEST_LABELS = 41
"""As many labels as can fill all recalls; with fewer, perfect detections do not reach 100
percent."""


def precision_at_recalls(
    events: Events, labels: Integers, weights: Integers | None = None
) -> Floats:
    """Precision and orientation similarity, the best at each recall or beyond.

    Args:
        events: Events of a class, level and metric in F frames.
        labels: Number of counted labels of each frame, shape (F,).
        weights: Number of times that each frame counts, shape (F,); None: once.

    Returns:
        Shape (2, 41), in [0, 1]; 0 at recalls that are not reached, or without any label.
    """
    once = np.ones_like(labels) if weights is None else weights
    return _precision(events, labels, once)


def average_precisions(precision: Floats) -> Floats:
    """AP11 and AP40 in percent, shape (..., 2), of precisions of shape (..., 41)."""
    means = [precision[..., slots].mean(axis=-1) for slots in (AP11_SLOTS, AP40_SLOTS)]
    return 100 * np.stack(means, axis=-1)


@lru_cache(maxsize=4096)
def best_average_precisions(labels: int) -> tuple[float, float]:
    """AP11 and AP40 in percent of detections that are the labels themselves.

    Each label found makes one cut-off at most, the first of which stands at recall 0: n labels fill
    n of the 41 recalls, and the development kit counts the others as precision 0.

    Args:
        labels: Number of counted labels; without any, precision is 0.

    Example:
        >>> [round(value, 2) for value in best_average_precisions(18)]
        [45.45, 42.5]
    """
    of_each = np.ones(labels)
    one, first = np.array([labels]), np.zeros(labels, np.int64)
    if not labels:
        return 0.0, 0.0
    surest = np.ones(1), np.zeros(1, np.int64)
    events = Events(of_each, first, *surest, one, np.zeros(1, np.int64), one.astype(float))
    ap11, ap40 = average_precisions(precision_at_recalls(events, one))[0].tolist()
    return ap11, ap40


def resampled(events: Events, labels: Integers, resamples: Integers) -> Floats:
    """AP11 and AP40 in percent of each resample, of precision and of orientation.

    Args:
        events: Events of a class, level and metric in F frames.
        labels: Number of counted labels of each frame, shape (F,).
        resamples: Number of times that each frame counts, shape (R, F).

    Returns:
        Shape (R, 2, 2): precision, orientation; AP11, AP40.  NaN where no label was drawn.
    """
    result = average_precisions(_resample(events, labels, resamples))
    result[resamples @ labels == 0] = np.nan
    return result


@kernel(nogil=True)
def _resample(events: Events, labels: Integers, resamples: Integers) -> Floats:
    """`_precision` of each resample, shape (R, 2, 41)."""
    result = np.empty((len(resamples), 2, SLOTS))
    for i in range(len(resamples)):
        curves = _precision(events, labels, resamples[i])
        for slot in range(SLOTS):
            result[i, 0, slot], result[i, 1, slot] = curves[0, slot], curves[1, slot]
    return result


@kernel(nogil=True)
def _precision(events: Events, labels: Integers, weights: Integers) -> Floats:
    """See `precision_at_recalls`.

    Invariant: cuts and events both fall in score, so that each event is added once.
    """
    result = np.zeros((2, SLOTS))
    cuts = _cuts(events, labels, weights)
    true_positives, false_positives, similarity = 0.0, 0.0, 0.0
    event = 0
    for slot in range(len(cuts)):
        while event < len(events.score) and events.score[event] >= cuts[slot]:
            weight = weights[events.frame[event]]
            if weight:
                true_positives += weight * events.true_positives[event]
                false_positives += weight * events.false_positives[event]
                similarity += weight * events.similarity[event]
            event += 1
        positives = true_positives + false_positives
        if positives > 0.0:
            result[0, slot] = true_positives / positives
            result[1, slot] = similarity / positives
    # The best at each recall or beyond.
    for slot in range(SLOTS - 2, -1, -1):
        for row in range(2):
            result[row, slot] = max(result[row, slot], result[row, slot + 1])
    return result


@kernel(nogil=True)
def _cuts(events: Events, labels: Integers, weights: Integers) -> Floats:
    """The scores, best first, at which recall comes closest to 0, 1/40, 2/40, ...

    The recall aimed at is summed up as the development kit does: its rounding decides ties.
    Invariant: a frame that is drawn several times counts each of its hits as often.
    """
    result = np.empty(SLOTS)
    wanted, hits = 0, 0
    for f in range(len(labels)):
        wanted += labels[f] * weights[f]
    for i in range(len(events.hit_score)):
        hits += weights[events.hit_frame[i]]
    found, nth, aim = 0, 0, 0.0
    for i in range(len(events.hit_score)):
        for _ in range(weights[events.hit_frame[i]]):
            nth += 1
            # Leave out a hit if the next one comes closer to the recall aimed at.
            recall, following = nth / wanted, (nth + 1) / wanted
            if nth < hits and following - aim < aim - recall:
                continue
            if found < SLOTS:
                result[found] = events.hit_score[i]
                found += 1
            aim += 1.0 / (SLOTS - 1.0)
    return result[:found]
