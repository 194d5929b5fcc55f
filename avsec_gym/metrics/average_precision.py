"""Average precision as the KITTI object benchmark measures it: image, bird's eye, 3D, orientation.

Geiger, Lenz, Urtasun: Are we ready for autonomous driving? CVPR 2012, and its development kit;
40 recall points after Simonelli et al., ICCV 2019.  `docs/average_precision.md` states the rules.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from types import MappingProxyType
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, Integers
from avsec_gym.metrics.average_precision_curves import (
    average_precisions,
    best_average_precisions,
    precision_at_recalls,
    resampled,
)
from avsec_gym.metrics.average_precision_frames import (
    COUNTED,
    LEVELS,
    CountStatus,
    Objects,
    detection_status,
    label_status,
    pooled,
)
from avsec_gym.metrics.average_precision_matching import match, overlaps
from avsec_gym.metrics.cluster_bootstrap import draw_resamples

METRICS = ("2d", "bev", "3d", "aos")
"""Metrics in the image, from above, in space; similarity of the observation angle, matched in the
image."""
CLASSES = ("Car", "Pedestrian", "Cyclist")

MinIou = Mapping[str, tuple[float, float, float]]
"""The overlap for each class: a match needs more than this in the image, from above, in space."""

STANDARD_IOU: MinIou = MappingProxyType(
    {"Car": (0.7, 0.7, 0.7), "Pedestrian": (0.5, 0.5, 0.5), "Cyclist": (0.5, 0.5, 0.5)}
)
"""What the benchmark asks for."""
LOW_IOU: MinIou = MappingProxyType(
    {"Car": (0.7, 0.5, 0.5), "Pedestrian": (0.5, 0.25, 0.25), "Cyclist": (0.5, 0.25, 0.25)}
)
"""The second, easier set that papers on stereo report beside it."""

_CONFIDENCE = (0.025, 0.975)


@dataclass(frozen=True, eq=False)
class AveragePrecision:
    """Average precision of C classes; the axes are class, metric (`METRICS`), level (`LEVELS`)."""

    classes: tuple[str, ...]
    min_iou: Floats
    """Shape (C, 4)."""
    labels: Integers
    """How many labels there were to find, shape (C, 3); without any, precision is 0."""
    precision: Floats
    """The best at each recall 0, 1/40, ..., 1 or beyond, in [0, 1], shape (C, 4, 3, 41).

    For ``aos``, the similarity; NaN where a detection or label of the class has no alpha.  For
    ``bev`` and ``3d`` NaN where all detections of the class are known in the image only.
    """
    drawn: Floats | None = None
    """AP11 and AP40 in percent of each of R bootstrap samples of frames, shape (C, 4, 3, R, 2); of
    as many frames and with the same seed, the samples are the same.  NaN where one has no label."""

    @cached_property
    def interval(self) -> Floats | None:
        """95 % of the bootstrap, shape (C, 4, 3, 2, 2): AP11 and AP40, low and high."""
        if self.drawn is None:
            return None
        rows = [_interval(values) for values in self.drawn.reshape(-1, *self.drawn.shape[-2:])]
        return np.reshape(rows, (*self.drawn.shape[:3], 2, 2))

    @property
    def ap11(self) -> Floats:
        """Percent at 11 recall points, shape (C, 4, 3); earlier papers report this one."""
        return average_precisions(self.precision)[..., 0]

    @property
    def ap40(self) -> Floats:
        """Percent at 40 recall points, shape (C, 4, 3); the leaderboard's since October 2019."""
        return average_precisions(self.precision)[..., 1]

    @property
    def ceiling(self) -> Floats:
        """What perfect detections of these labels reach, percent, shape (C, 3, 2): AP11 and AP40.

        Below 100 with fewer than `FEWEST_LABELS`; the same for every metric.
        """
        best = [best_average_precisions(count) for count in self.labels.ravel().tolist()]
        return np.reshape(best, (*self.labels.shape, 2))

    def value(
        self, category: str, metric: str = "3d", level: str = "moderate", recall_points: int = 11
    ) -> float:
        """One figure, percent.

        Raises:
            ConfigurationError: There is no such class, metric, level or number of recall points.
        """
        for given, known in (
            (category, self.classes),
            (metric, METRICS),
            (level, LEVELS),
            (recall_points, (11, 40)),
        ):
            if given not in known:
                raise ConfigurationError(
                    f"{given!r} was not measured; known: {', '.join(map(str, known))}"
                )
        values = self.ap11 if recall_points == 11 else self.ap40
        return float(
            values[self.classes.index(category), METRICS.index(metric), LEVELS.index(level)]
        )

    def to_json(self) -> dict[str, dict[str, dict[str, Any]]]:
        """``{class: {metric: {"ap11": [easy, moderate, hard], "ap40": [...]}}}``, percent.

        Intervals, where there are any, stand beside them: ``"ap11_interval": [[low, high], ...]``.
        What is not known is None.
        """
        result: dict[str, dict[str, dict[str, Any]]] = {name: {} for name in self.classes}
        interval = self.interval
        for (c, category), (m, metric) in product(enumerate(self.classes), enumerate(METRICS)):
            values = {"ap11": self.ap11[c, m], "ap40": self.ap40[c, m]}
            if interval is not None:
                values["ap11_interval"] = interval[c, m, :, 0]
                values["ap40_interval"] = interval[c, m, :, 1]
            result[category][metric] = {name: _plain(value) for name, value in values.items()}
        return result


def average_precision(
    truth: Sequence[Boxes3D],
    detections: Sequence[Boxes3D],
    *,
    classes: Sequence[str] = CLASSES,
    min_iou: MinIou = STANDARD_IOU,
    resamples: int = 0,
    seed: int = 0,
    together: Sequence[str] | None = None,
) -> AveragePrecision:
    """Score a detector on F frames.

    Args:
        truth: Labels of each frame, DontCare regions included (`read_labels` keeps them on demand).
            Where truncation or occlusion is unknown, it does not make a label harder.
        detections: Detections in the same frames; empty where nothing was found.
        classes: Classes to be found, without regard to upper or lower case.
        min_iou: Least overlap for each class: `STANDARD_IOU`, `LOW_IOU` or another.
        resamples: Number of times that frames are drawn anew for the 95 % interval; 0: no interval.
        seed: Seed of these draws.
        together: Group of each frame, such as its drive: frames that are alike are drawn all or
            none.  None: each by itself.  One group alone gives no interval.

    Raises:
        ConfigurationError: The frames do not fit together, boxes lack 2D boxes, or a class has no
            threshold.
    """
    _check_arguments(len(truth), len(detections), classes, min_iou)
    # Once for all: pooled boxes, their overlaps, and the frames of each resample.
    labels, found = pooled(truth, "labels"), pooled(detections, "detections")
    common = overlaps(labels, found)
    names, group = np.unique(
        range(len(truth)) if together is None else together, return_inverse=True
    )
    samples = draw_resamples(len(names), resamples, seed)[:, group] if resamples else None
    tasks = list(product(range(len(classes)), range(len(LEVELS)), range(3)))

    def score(task: tuple[int, int, int]) -> tuple[Floats, Floats | None, Integers]:
        """Precision and orientation (2, 41), their resamples (R, 2, 2), labels of each frame."""
        number, level, metric = task
        category = classes[number]
        wanted = label_status(labels, category, level)
        given = detection_status(found, category, level)
        counted = np.bincount(labels.frame[wanted == COUNTED], minlength=len(truth))
        events = match(labels, found, common, wanted, given, metric, min_iou[category][metric])
        curve = precision_at_recalls(events, counted)
        again = None if samples is None else resampled(events, counted, samples)
        # What the data cannot answer is NaN, not 0.
        if metric == 0 and not _orientation_is_known(labels, wanted, found, given):
            curve[1] = np.nan
            if again is not None:
                again[:, 1] = np.nan
        if metric > 0 and not _places_are_known(found, category):
            curve[:] = np.nan
            if again is not None:
                again[:] = np.nan
        return curve, again, counted

    shape = (len(classes), len(METRICS), len(LEVELS))
    precision = np.zeros((*shape, 41))
    drawn = None if samples is None else np.full((*shape, resamples, 2), np.nan)
    to_find = np.zeros((len(classes), len(LEVELS)), np.int64)
    with ThreadPoolExecutor(min(len(tasks), os.cpu_count() or 1)) as pool:
        # The kernels let go of the interpreter; results come in order.
        for (number, level, metric), result in zip(tasks, pool.map(score, tasks), strict=True):
            curve, again, counted = result
            to_find[number, level] = counted.sum()
            for row, place in enumerate((metric, 3) if metric == 0 else (metric,)):
                precision[number, place, level] = curve[row]
                if drawn is not None and again is not None:
                    drawn[number, place, level] = again[:, row]
    if drawn is not None and len(names) < 2:
        # What is drawn of one group is always the same.
        drawn[:] = np.nan
    thresholds = np.array([(*min_iou[name], min_iou[name][0]) for name in classes])
    return AveragePrecision(tuple(classes), thresholds, to_find, precision, drawn)


def _check_arguments(labelled: int, detected: int, classes: Sequence[str], min_iou: MinIou) -> None:
    if labelled != detected or not labelled:
        raise ConfigurationError(
            f"average precision compares one or more frames with as many: {labelled} frames"
            f" have labels, {detected} detections"
        )
    if unknown := [name for name in classes if name not in min_iou]:
        raise ConfigurationError(
            f"min_iou has no threshold for {', '.join(unknown)}; known: {', '.join(min_iou)}"
        )


def _orientation_is_known(
    labels: Objects, wanted: CountStatus, detections: Objects, given: CountStatus
) -> bool:
    unknown = np.isnan(labels.alpha[wanted == COUNTED]).any()
    return not (unknown or np.isnan(detections.alpha[given == COUNTED]).any())


def _places_are_known(detections: Objects, category: str) -> bool:
    """Whether any detection of a class has a place in space; where there is none, any at all."""
    own = detections.category == category.lower()
    looked_at = detections.image_only[own] if own.any() else detections.image_only
    return not len(looked_at) or not looked_at.all()


def _interval(values: Floats) -> Floats:
    """Low and high of R resamples of shape (R, 2), shape (2, 2); NaN where none has a value."""
    known = values[~np.isnan(values).any(axis=1)]
    return np.quantile(known, _CONFIDENCE, axis=0).T if len(known) else np.full((2, 2), np.nan)


def _plain(values: Floats) -> Any:
    """Nested lists with None for NaN."""
    if values.ndim == 0:
        return None if np.isnan(values) else round(float(values), 4)
    return [_plain(value) for value in values]
