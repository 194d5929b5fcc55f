"""Pairs of boxes by shapely, and matches by the development kit's loops, at every cut-off."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
import shapely

from avsec_gym.geometry import rectangle_polygons
from avsec_gym.metrics.average_precision_frames import (
    COUNTED,
    IGNORED,
    OTHER,
    Extents,
    Objects,
)
from avsec_gym.metrics.average_precision_matching import Overlaps, match, overlaps


def _objects(
    counts: list[int], rng: np.random.Generator, spread: float = 6.0, unlabelled: float = 0.0
) -> Objects:
    """Random ones, so many in each frame."""
    number = sum(counts)
    corner, size = rng.uniform(0, 80, (number, 2)), rng.uniform(15, 60, (number, 2))
    ground = np.column_stack(
        [
            rng.uniform(-spread, spread, (number, 2)),
            rng.uniform(2, 5, number),
            rng.uniform(1, 3, number),
            rng.uniform(-3, 3, number),
        ]
    )
    top = rng.uniform(-1.5, 1.5, number)
    names = np.where(rng.random(number) < unlabelled, "dontcare", "car")
    return Objects(
        Extents(
            np.cumsum([0, *counts]),
            np.hstack([corner, corner + size]),
            ground,
            np.column_stack([top, top + rng.uniform(0.5, 2, number)]),
        ),
        names,
        # Few scores: many are equal.
        np.round(rng.random(number), 1),
        rng.uniform(-3, 3, number),
        np.zeros(number),
        np.zeros(number),
        np.zeros(number, bool),
    )


@pytest.mark.parametrize("spread", [2.5, 4.0])
def test_pairs_have_the_overlaps_that_shapely_finds(spread: float) -> None:
    rng = np.random.default_rng(1)
    labels, detections = (
        _objects([4, 0, 3, 6, 2], rng, spread, 0.3),
        _objects([5, 3, 0, 7, 1], rng, spread),
    )
    first, last = labels.extents.first, detections.extents.first
    pairs, shares, dont_care = [], [], np.zeros(16)
    ground, other_ground = (
        rectangle_polygons(
            each.extents.ground[:, [0, 1, 4]],
            each.extents.ground[:, 2],
            each.extents.ground[:, 3],
        )
        for each in (labels, detections)
    )
    image, other_image = (shapely.box(*each.extents.box2d.T) for each in (labels, detections))
    for f in range(5):
        for i in range(first[f], first[f + 1]):
            for j in range(last[f], last[f + 1]):
                common = image[i].intersection(other_image[j]).area
                if labels.category[i] == "dontcare":
                    dont_care[j] = max(dont_care[j], common / other_image[j].area)
                    continue
                area = ground[i].intersection(other_ground[j]).area
                if common == 0 and area < 1e-12:
                    continue
                (top, bottom), (other_top, other_bottom) = (
                    labels.extents.vertical[i],
                    detections.extents.vertical[j],
                )
                deep = max(min(bottom, other_bottom) - max(top, other_top), 0.0)
                inside = area * deep
                size = ground[i].area * (bottom - top)
                other_size = other_ground[j].area * (other_bottom - other_top)
                pairs.append((i, j))
                shares.append(
                    (
                        common / image[i].union(other_image[j]).area,
                        area / ground[i].union(other_ground[j]).area,
                        inside / (size + other_size - inside),
                    )
                )
    found = overlaps(labels, detections)
    assert list(zip(found.label.tolist(), found.detection.tolist(), strict=True)) == pairs
    assert pytest.approx(np.array(shares), abs=1e-9) == found.iou.T
    assert found.dont_care == pytest.approx(dont_care, abs=1e-12)
    # Some touch in the image alone, some on the ground alone, some at other heights.
    image_iou, ground_iou, iou = np.array(shares).T
    assert ((image_iou == 0) & (ground_iou > 0)).any()
    assert ((image_iou > 0) & (ground_iou < 1e-12)).any()
    assert ((ground_iou > 0.01) & (iou == 0)).any()
    assert (dont_care > 0).any()


@dataclass(frozen=True)
class _Frame:
    """What the development kit's loops look at."""

    labels: list[int]
    detections: list[int]


@dataclass(frozen=True, eq=False)
class _Case:
    labels: Objects
    detections: Objects
    common: Overlaps
    label_status: np.ndarray
    detection_status: np.ndarray

    def frames(self) -> list[_Frame]:
        return [
            _Frame(
                *(
                    list(range(each.extents.first[f], each.extents.first[f + 1]))
                    for each in (self.labels, self.detections)
                )
            )
            for f in range(len(self.labels.extents.first) - 1)
        ]


def _case(seed: int) -> _Case:
    """Pairs and overlaps at random: geometry is not asked."""
    rng = np.random.default_rng(seed)
    counts, found = rng.integers(0, 5, 4).tolist(), rng.integers(0, 6, 4).tolist()
    labels, detections = _objects(counts, rng), _objects(found, rng)
    pairs = [
        (i, j)
        for f in range(4)
        for i in range(labels.extents.first[f], labels.extents.first[f + 1])
        for j in range(detections.extents.first[f], detections.extents.first[f + 1])
        if rng.random() < 0.8
    ]
    label, detection = np.array(pairs, np.int64).reshape(-1, 2).T
    iou = np.round(rng.uniform(0.3, 1.0, (3, len(pairs))), 1)
    common = Overlaps(
        np.ascontiguousarray(label), np.ascontiguousarray(detection), iou, rng.random(sum(found))
    )
    kinds = np.array([COUNTED, COUNTED, COUNTED, IGNORED, OTHER], np.int8)
    return _Case(
        labels,
        detections,
        common,
        rng.choice(kinds, sum(counts)),
        rng.choice(kinds, sum(found)),
    )


def _devkit(
    case: _Case, frame: _Frame, metric: int, min_iou: float, cut: float | None
) -> tuple[int, int, float, list[int]]:
    """The counts of one frame, label by label; without a cut, the pass that finds thresholds."""
    pairs = zip(case.common.label.tolist(), case.common.detection.tolist(), strict=True)
    share = dict(zip(pairs, case.common.iou[metric].tolist(), strict=True))
    score, kinds = case.detections.score, case.detection_status
    taken: set[int] = set()
    hits, similarity = [], 0.0
    for i in frame.labels:
        if case.label_status[i] == OTHER:
            continue
        best, best_iou, best_score, best_is_ignored = -1, 0.0, -math.inf, False
        for j in frame.detections:
            here = share.get((i, j), 0.0)
            if kinds[j] == OTHER or j in taken or here <= min_iou:
                continue
            if cut is None:
                if score[j] > best_score:
                    best, best_score = j, score[j]
                continue
            if score[j] < cut:
                continue
            if kinds[j] == COUNTED and (here > best_iou or best_is_ignored):
                best, best_iou, best_is_ignored = j, here, False
            elif kinds[j] == IGNORED and best < 0:
                best, best_is_ignored = j, True
        if best < 0:
            continue
        taken.add(best)
        if case.label_status[i] == COUNTED and kinds[best] == COUNTED:
            hits.append(best)
            apart = case.labels.alpha[i] - case.detections.alpha[best]
            similarity += (1 + math.cos(apart)) / 2
    alarms = 0
    for j in frame.detections:
        excused = metric == 0 and case.common.dont_care[j] > min_iou
        alone = j not in taken and kinds[j] == COUNTED and not excused
        alarms += alone and (cut is None or score[j] >= cut)
    return len(hits), alarms, similarity, hits


@pytest.mark.parametrize("metric", [0, 1, 2])
@pytest.mark.parametrize("min_iou", [0.4, 0.5])
def test_events_add_up_to_what_the_development_kit_counts(metric: int, min_iou: float) -> None:
    contested = 0
    for seed in range(40):
        case = _case(seed)
        events = match(
            case.labels,
            case.detections,
            case.common,
            case.label_status,
            case.detection_status,
            metric,
            min_iou,
        )
        assert (np.diff(events.score) <= 0).all()
        hits = []
        for f, frame in enumerate(case.frames()):
            hits += [
                (case.detections.score[j], f)
                for j in _devkit(case, frame, metric, min_iou, None)[3]
            ]
            for cut in np.linspace(-0.05, 1.05, 12):
                tp, fp, alike, _ = _devkit(case, frame, metric, min_iou, float(cut))
                so_far = (events.frame == f) & (events.score >= cut)
                assert events.true_positives[so_far].sum() == tp
                assert events.false_positives[so_far].sum() == fp
                assert events.similarity[so_far].sum() == pytest.approx(alike, abs=1e-9)
                contested += tp > 1
        hits.sort(key=lambda hit: -hit[0])
        assert list(zip(events.hit_score, events.hit_frame, strict=True)) == hits
    assert contested > 50
