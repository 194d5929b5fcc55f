"""Detections against labels, frame by frame: the numba kernels of average precision.

The development kit matches a frame anew for each of up to 41 score cut-offs.  What a frame gives
changes only where the cut-off passes one of its own scores, so here it is matched once for each of
these, and what changes there (true positives, false positives, orientation similarity) becomes an
*event*.  Any sum over frames at any cut-off is then a sum of events: exact, and so cheap that
frames can be resampled a thousand times.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import overlap_area
from avsec_gym.geometry import Floats, Integers
from avsec_gym.kernels import kernel
from avsec_gym.kitti.labels import DONT_CARE
from avsec_gym.metrics.average_precision_frames import COUNTED, OTHER, CountStatus, Extents, Objects

Flags = NDArray[np.bool_]


class Overlaps(NamedTuple):
    """The P pairs of a label and a detection that touch in the image or on the ground.

    Ordered as the files are: by frame, label, detection.
    """

    label: Integers
    detection: Integers
    iou: Floats
    """The overlap in the image, from above, in space, shape (3, P)."""
    dont_care: Floats
    """Largest share of each detection's 2D box in one DontCare region, shape (N,)."""


class Events(NamedTuple):
    """What a class, level and metric gives at each score, best first."""

    hit_score: Floats
    """Hit score of the detections found in the threshold pass, shape (S,)."""
    hit_frame: Integers
    score: Floats
    """Where the cut-off, falling, changes what a frame gives, shape (E,)."""
    frame: Integers
    true_positives: Integers
    """The change; negative where one more detection spoils a match."""
    false_positives: Integers
    similarity: Floats
    """Change of the sum of (1 + cos(error of alpha)) / 2 over true positives."""


class _Contest(NamedTuple):
    """The Q pairs close enough for a match, and all detections."""

    first: Integers
    """The pairs of frame f begin at first[f], shape (F + 1,)."""
    label: Integers
    detection: Integers
    iou: Floats
    similarity: Floats
    is_hit: Flags
    """Whether label and detection both count."""
    score: Floats
    """Score of the detections, shape (N,), as the three below."""
    frame: Integers
    counts: Flags
    is_alarm: Flags
    """Whether it is a false positive when it matches nothing."""


def overlaps(labels: Objects, detections: Objects) -> Overlaps:
    """Compare every label with every detection of its frame."""
    unlabelled = labels.category == DONT_CARE.lower()
    return Overlaps(*_overlaps(labels.extents, unlabelled, detections.extents))


def match(
    labels: Objects,
    detections: Objects,
    common: Overlaps,
    label_status: CountStatus,
    detection_status: CountStatus,
    metric: int,
    min_iou: float,
) -> Events:
    """Match every frame.

    Args:
        labels: Ground truth, DontCare regions included.
        detections: Detections in the same frames.
        common: Overlaps of labels and detections.
        label_status: Status of each label, see `average_precision_frames`.
        detection_status: Status of each detection, see the same.
        metric: Number of the metric: 0 in the image, 1 from above, 2 in space.
        min_iou: A match needs more than this.
    """
    close = common.iou[metric] > min_iou
    close &= (label_status != OTHER)[common.label] & (detection_status != OTHER)[common.detection]
    label, detection = common.label[close], common.detection[close]
    counts = detection_status == COUNTED
    # Only the image has regions without labels.
    is_alarm = counts & (common.dont_care <= min_iou) if metric == 0 else counts
    contest = _Contest(
        np.searchsorted(label, labels.extents.first),
        label,
        detection,
        common.iou[metric][close],
        0.5 * (1 + np.cos(labels.alpha[label] - detections.alpha[detection])),
        (label_status == COUNTED)[label] & counts[detection],
        detections.score,
        detections.frame,
        counts,
        is_alarm,
    )
    hits, score, frame, true_positives, false_positives, similarity = _match(contest)
    hits = hits[np.argsort(-contest.score[hits], kind="stable")]
    order = np.argsort(-score, kind="stable")
    return Events(
        contest.score[hits],
        contest.frame[hits],
        score[order],
        frame[order],
        true_positives[order],
        false_positives[order],
        similarity[order],
    )


@kernel(nogil=True)
def _overlaps(
    labels: Extents, unlabelled: Flags, detections: Extents
) -> tuple[Integers, Integers, Floats, Floats]:
    """The fields of `Overlaps`.

    Invariant: pairs are written in the order frame, label, detection, on which `_match` relies to
    find the pairs of a frame, and of a label, side by side.
    """
    # Memory for every pair of a frame; those that touch are few.
    most = 0
    for f in range(len(labels.first) - 1):
        most += (labels.first[f + 1] - labels.first[f]) * (
            detections.first[f + 1] - detections.first[f]
        )
    label, detection = np.empty(most, np.int64), np.empty(most, np.int64)
    iou, dont_care = np.zeros((3, most)), np.zeros(len(detections.box2d))
    pair = 0
    for f in range(len(labels.first) - 1):
        for i in range(labels.first[f], labels.first[f + 1]):
            for j in range(detections.first[f], detections.first[f + 1]):
                one, other = labels.box2d[i], detections.box2d[j]
                width = min(one[2], other[2]) - max(one[0], other[0])
                height = min(one[3], other[3]) - max(one[1], other[1])
                common = width * height if width > 0.0 and height > 0.0 else 0.0
                size = (other[2] - other[0]) * (other[3] - other[1])
                # DontCare regions make no pair: they excuse a detection by its covered share.
                if unlabelled[i]:
                    if common > 0.0:
                        dont_care[j] = max(dont_care[j], common / size)
                    continue
                area = overlap_area(labels.ground[i], detections.ground[j])
                if common == 0.0 and area == 0.0:
                    continue
                label[pair], detection[pair] = i, j
                own_size = (one[2] - one[0]) * (one[3] - one[1])
                iou[0, pair] = _share(common, own_size, size)
                base = labels.ground[i, 2] * labels.ground[i, 3]
                other_base = detections.ground[j, 2] * detections.ground[j, 3]
                iou[1, pair] = _share(area, base, other_base)
                one, other = labels.vertical[i], detections.vertical[j]
                deep, other_deep = one[1] - one[0], other[1] - other[0]
                common = area * max(min(one[1], other[1]) - max(one[0], other[0]), 0.0)
                iou[2, pair] = _share(common, base * deep, other_base * other_deep)
                pair += 1
    return label[:pair], detection[:pair], iou[:, :pair], dont_care


@kernel(nogil=True)
def _share(common: float, one: float, other: float) -> float:
    """Intersection over union of two sizes; 0 where nothing is common."""
    return common / (one + other - common) if common > 0.0 else 0.0


@kernel(nogil=True)
def _match(
    contest: _Contest,
) -> tuple[Integers, Floats, Integers, Integers, Integers, Floats]:
    """The detections found in the threshold pass, and the columns of `Events` from score on.

    Invariants: a frame's events, added up to any cut-off, are what the development kit counts in
    it there; there is at most one event for each detection, so that memory of N rows suffices;
    `free` of a frame's contested detections is set by `_assign` before it is read.
    """
    # Detections in no pair: they match nothing at any cut-off.
    most = len(contest.score)
    hit, hits = np.empty(most, np.int64), 0
    at, frame, events = np.empty(most), np.empty(most, np.int64), 0
    true_positives, false_positives = np.zeros(most, np.int64), np.zeros(most, np.int64)
    similarity = np.zeros(most)
    won, free = np.empty(len(contest.label), np.int64), np.ones(most, np.bool_)
    for p in range(len(contest.label)):
        free[contest.detection[p]] = False
    for j in range(most):
        if free[j] and contest.is_alarm[j]:
            # It comes near no label: a false alarm from its own score on, whatever others do.
            at[events], frame[events], false_positives[events] = (
                contest.score[j],
                contest.frame[j],
                1,
            )
            events += 1
    for f in range(len(contest.first) - 1):
        # Threshold pass: the scores at which recall grows.
        for k in range(_assign(contest, f, -np.inf, True, won, free)):
            if contest.is_hit[won[k]]:
                hit[hits] = contest.detection[won[k]]
                hits += 1
        # Counting pass, at each of the frame's own scores; what changes is an event.
        before_tp, before_fp, before_similarity = 0, 0, 0.0
        cut = _highest_below(np.inf, contest, f)
        while cut > -np.inf:
            tp, fp, alike = 0, 0, 0.0
            for k in range(_assign(contest, f, cut, False, won, free)):
                if contest.is_hit[won[k]]:
                    tp += 1
                    alike += contest.similarity[won[k]]
            for p in range(contest.first[f], contest.first[f + 1]):
                j = contest.detection[p]
                if free[j] and contest.is_alarm[j] and contest.score[j] >= cut:
                    fp += 1
                    free[j] = False  # Counted, though it may be close to other labels, too.
            at[events], frame[events] = cut, f
            true_positives[events] = tp - before_tp
            false_positives[events] = fp - before_fp
            similarity[events] = alike - before_similarity
            before_tp, before_fp, before_similarity = tp, fp, alike
            events += 1
            cut = _highest_below(cut, contest, f)
    return (
        hit[:hits],
        at[:events],
        frame[:events],
        true_positives[:events],
        false_positives[:events],
        similarity[:events],
    )


@kernel(nogil=True)
def _assign(
    contest: _Contest, f: int, cut: float, surest_wins: bool, won: Integers, free: Flags
) -> int:
    """Assign to each label of a frame, in order, one of the free detections above the cut.

    In the threshold pass the surest wins; in the counting pass the closest, and small ones only
    where nothing else is close enough.

    Args:
        contest: Pairs of all frames.
        f: The frame.
        cut: The lowest score that takes part.
        surest_wins: Whether this is the threshold pass.
        won: Memory that gets the pairs that match.
        free: Whether each detection is taken by no label; set here.

    Returns:
        How many labels got one.
    """
    # The pairs of a label stand side by side: the inner loop passes all of them.
    p, last, count = contest.first[f], contest.first[f + 1], 0
    for q in range(p, last):
        free[contest.detection[q]] = True
    while p < last:
        label, best, best_at = contest.label[p], -1, -1
        while p < last and contest.label[p] == label:
            j = contest.detection[p]
            if free[j] and contest.score[j] >= cut:
                if best < 0:
                    better = True
                elif surest_wins:
                    better = contest.score[j] > contest.score[best]
                else:
                    closer = contest.iou[p] > contest.iou[best_at]
                    better = contest.counts[j] and (closer or not contest.counts[best])
                if better:
                    best, best_at = j, p
            p += 1
        if best >= 0:
            free[best] = False
            won[count] = best_at
            count += 1
    return count


@kernel(nogil=True)
def _highest_below(limit: float, contest: _Contest, f: int) -> float:
    """The next lower score of a frame's contested detections; -inf after the last."""
    result = -np.inf
    for p in range(contest.first[f], contest.first[f + 1]):
        score = contest.score[contest.detection[p]]
        if score < limit:
            result = max(result, score)
    return result
