"""Average precision against a slow reading of the specification: plain loops, shapely's clipping.

Nothing here is shared with the package: rules, overlaps, matching and recall points are written a
second time, one object after the other and one cut-off after the other.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given, settings
from hypothesis import strategies as st

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.average_precision import (
    LEVELS,
    LOW_IOU,
    METRICS,
    STANDARD_IOU,
    average_precision,
)

HEIGHTS, OCCLUSIONS, TRUNCATIONS = (40, 25, 25), (0, 1, 2), (0.15, 0.3, 0.5)
NEIGHBOUR = {"Car": "Van", "Pedestrian": "Person_sitting"}
COUNTED, IGNORED, OTHER = "counted", "ignored", "other"


def objects(boxes: Boxes3D) -> list[dict[str, Any]]:
    result = []
    for i in range(len(boxes)):
        x, y, z = boxes.location[i]
        height, width, length = boxes.dimensions[i]
        ground = shapely.box(-length / 2, -width / 2, length / 2, width / 2)
        ground = shapely.affinity.rotate(
            ground, -boxes.rotation_y[i], origin=(0, 0), use_radians=True
        )
        result.append(
            {
                "name": str(boxes.category[i]),
                "image": shapely.box(*boxes.box2d[i]),
                "pixels": boxes.box2d[i][3] - boxes.box2d[i][1],
                "ground": shapely.affinity.translate(ground, x, z),
                "bottom": y,
                "top": y - height,
                "score": boxes.score[i],
                "alpha": boxes.alpha[i],
                "truncation": boxes.truncation[i],
                "occlusion": boxes.occlusion[i],
            }
        )
    return result


def label_kind(label: dict[str, Any], category: str, level: int) -> str:
    if label["name"] == NEIGHBOUR.get(category):
        return IGNORED
    if label["name"] != category:
        return OTHER
    if label["pixels"] <= HEIGHTS[level] or label["occlusion"] > OCCLUSIONS[level]:
        return IGNORED
    return IGNORED if label["truncation"] > TRUNCATIONS[level] else COUNTED


def detection_kind(detection: dict[str, Any], category: str, level: int) -> str:
    if detection["pixels"] < HEIGHTS[level]:
        return IGNORED
    return COUNTED if detection["name"] == category else OTHER


def iou(one: dict[str, Any], other: dict[str, Any], metric: str) -> float:
    if metric in ("2d", "aos"):
        common = one["image"].intersection(other["image"]).area
        return common / (one["image"].area + other["image"].area - common)
    common = one["ground"].intersection(other["ground"]).area
    size, other_size = one["ground"].area, other["ground"].area
    if metric == "3d":
        high = min(one["bottom"], other["bottom"]) - max(one["top"], other["top"])
        common *= max(high, 0.0)
        size *= one["bottom"] - one["top"]
        other_size *= other["bottom"] - other["top"]
    return common / (size + other_size - common)


def match_frame(frame: Any, metric: str, min_iou: float, cut: float | None) -> dict[str, Any]:
    """The threshold pass where there is no cut, else the counting pass."""
    labels, label_kinds, detections, kinds, table = frame
    taken = [False] * len(detections)
    hits, similarity, misses = [], 0.0, 0
    for i in range(len(labels)):
        if label_kinds[i] == OTHER:
            continue
        candidates = [
            j
            for j in range(len(detections))
            if kinds[j] != OTHER
            and not taken[j]
            and table[i][j] > min_iou
            and (cut is None or detections[j]["score"] >= cut)
        ]
        if not candidates:
            misses += label_kinds[i] == COUNTED
            continue
        if cut is None:
            winner = max(candidates, key=lambda j: (detections[j]["score"], -j))
        else:
            proper = [j for j in candidates if kinds[j] == COUNTED]
            winner = max(proper, key=lambda j: (table[i][j], -j)) if proper else candidates[0]
        taken[winner] = True
        if label_kinds[i] == COUNTED and kinds[winner] == COUNTED:
            hits.append(detections[winner]["score"])
            similarity += (1 + math.cos(labels[i]["alpha"] - detections[winner]["alpha"])) / 2
    alarms = 0
    for j in range(len(detections)):
        if taken[j] or kinds[j] != COUNTED or (cut is not None and detections[j]["score"] < cut):
            continue
        image = detections[j]["image"]
        excused = metric in ("2d", "aos") and any(
            label["name"] == "DontCare"
            and image.intersection(label["image"]).area / image.area > min_iou
            for label in labels
        )
        alarms += not excused
    return {"hits": hits, "similarity": similarity, "alarms": alarms, "misses": misses}


def slow_curve(frames: list[Any], metric: str, min_iou: float) -> tuple[list[float], int]:
    passes = [match_frame(frame, metric, min_iou, None) for frame in frames]
    scores = sorted((score for image in passes for score in image["hits"]), reverse=True)
    wanted = sum(kind == COUNTED for frame in frames for kind in frame[1])
    cuts, target = [], 0.0
    for i, score in enumerate(scores):
        here, following = (i + 1) / wanted, (i + 2) / wanted
        if i + 1 < len(scores) and following - target < target - here:
            continue
        cuts.append(score)
        target += 1 / 40
    curve = [0.0] * 41
    for slot, cut in enumerate(cuts):
        sums = [match_frame(frame, metric, min_iou, cut) for frame in frames]
        hits, alarms = (sum(len(s["hits"]) for s in sums), sum(s["alarms"] for s in sums))
        gain = sum(s["similarity"] for s in sums) if metric == "aos" else hits
        curve[slot] = gain / (hits + alarms) if hits + alarms else 0.0
    return [max(curve[slot:]) for slot in range(41)], wanted


def slow_average_precision(
    truth: list[Boxes3D], detections: list[Boxes3D], category: str, metric: str, level: int,
    min_iou: float,
) -> tuple[float, float, int]:  # fmt: skip
    frames = []
    for labels, found in zip(map(objects, truth), map(objects, detections), strict=True):
        table = [
            [0.0 if label["name"] == "DontCare" else iou(label, box, metric) for box in found]
            for label in labels
        ]
        kinds = [label_kind(label, category, level) for label in labels]
        found_kinds = [detection_kind(box, category, level) for box in found]
        frames.append((labels, kinds, found, found_kinds, table))
    curve, wanted = slow_curve(frames, metric, min_iou)
    return 100 * sum(curve[::4]) / 11, 100 * sum(curve[1:]) / 40, wanted


NAMES = ["Car", "Car", "Car", "Van", "Pedestrian", "Person_sitting", "Cyclist", "Truck"]


def random_frame(random: np.random.Generator, crowd: int) -> tuple[Boxes3D, Boxes3D]:
    """Labels, and detections that repeat, shift, confuse and invent them; scores have ties."""
    count = int(random.integers(0, crowd + 1))
    labels = random_boxes(random, count)
    copies = random.integers(0, count, int(random.integers(0, 2 * count + 1))) if count else []
    repeated = labels[np.array(copies, int)]
    repeated = repeated[repeated.category != "DontCare"]
    shifted = replace(
        repeated,
        location=repeated.location + random.normal(0, 0.15, repeated.location.shape),
        dimensions=repeated.dimensions * random.uniform(0.9, 1.1, repeated.dimensions.shape),
        rotation_y=repeated.rotation_y + random.normal(0, 0.05, len(repeated)),
        alpha=repeated.alpha + random.normal(0, 0.7, len(repeated)),
        box2d=repeated.box2d + np.round(random.normal(0, 3, repeated.box2d.shape)),
    )
    clutter = random_boxes(random, int(random.integers(0, 4)))
    found = Boxes3D.concatenate([shifted, clutter[clutter.category != "DontCare"]])
    confused = random.random(len(found)) < 0.2
    return labels, replace(
        found,
        score=np.round(random.random(len(found)), int(random.integers(1, 4))),
        category=np.where(confused, random.choice(NAMES, len(found)), found.category),
    )


def random_boxes(random: np.random.Generator, count: int) -> Boxes3D:
    left = random.uniform(0, 1000, (count, 1)).round()
    top = random.uniform(100, 200, (count, 1)).round()
    size = np.hstack(
        [
            random.uniform(30, 200, (count, 1)).round(),
            random.choice([20, 25, 26, 39, 40, 41, 80], (count, 1)),
        ]
    )
    category = random.choice(NAMES, count)
    if count and random.random() < 0.5:
        category[-1] = "DontCare"
        size[-1] *= 3
    return Boxes3D(
        location=random.uniform([-8, 1, 5], [8, 2, 25], (count, 3)),
        dimensions=random.uniform([1.3, 1.4, 3.2], [1.9, 1.9, 4.6], (count, 3)),
        rotation_y=random.uniform(-3, 3, count),
        score=np.ones(count),
        category=category,
        box2d=np.hstack([left, top, left + size[:, :1], top + size[:, 1:]]),
        truncation=random.choice([0, 0.15, 0.2, 0.3, 0.4, 0.7], count),
        occlusion=random.choice([0, 0, 1, 2, 3], count),
        alpha=random.uniform(-3, 3, count),
    )  # fmt: skip


@pytest.mark.parametrize("min_iou", [STANDARD_IOU, LOW_IOU], ids=["standard", "low"])
@settings(max_examples=8)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 20), crowd=st.integers(1, 12))
def test_every_figure_agrees_with_the_slow_reading(
    min_iou: Any, seed: int, count: int, crowd: int
) -> None:
    random = np.random.default_rng(seed)
    frames = [random_frame(random, crowd) for _ in range(count)]
    truth, detections = [labels for labels, _ in frames], [found for _, found in frames]
    fast = average_precision(truth, detections, min_iou=min_iou)
    for c, category in enumerate(fast.classes):
        for m, metric in enumerate(METRICS):
            for level in range(len(LEVELS)):
                threshold = min_iou[category][m % 3]
                ap11, ap40, wanted = slow_average_precision(
                    truth, detections, category, metric, level, threshold
                )
                where = (seed, count, crowd, category, metric, level)
                assert fast.labels[c, level] == wanted, where
                assert fast.ap11[c, m, level] == pytest.approx(ap11, abs=1e-9), where
                assert fast.ap40[c, m, level] == pytest.approx(ap40, abs=1e-9), where


@pytest.mark.parametrize("count", [59, 60, 100, 133, 180])
def test_cut_offs_of_many_labels_agree_with_the_slow_reading(count: int) -> None:
    """More labels than recall points: most scores are passed over, and some choices are ties."""
    random = np.random.default_rng(count)
    whole = replace(random_boxes(random, 1), category=np.array(["Car"]), occlusion=np.zeros(1))
    truth = [replace(whole, truncation=np.zeros(1), box2d=np.array([[0.0, 0, 90, 90]]))] * count
    aside = replace(truth[0], location=whole.location + 50, box2d=truth[0].box2d + 500)
    both = Boxes3D.concatenate([truth[0], aside])
    for share in (0.55, 0.7, 0.9, 1.0):
        detections = [
            replace(both, score=np.round(random.random(2), 2))[random.random(2) < (share, 0.3)]
            for _ in range(count)
        ]
        fast = average_precision(truth, detections, classes=["Car"])
        ap11, ap40, _ = slow_average_precision(truth, detections, "Car", "3d", 0, 0.7)
        assert fast.ap11[0, 2, 0] == pytest.approx(ap11, abs=1e-9)
        assert fast.ap40[0, 2, 0] == pytest.approx(ap40, abs=1e-9)
