"""Tables of what optical attacks do to detectors, and of the baseline that detectors make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from avsec_gym.drawing.page_table import Table, TableCell, figure, name, number
from avsec_gym.experiments.chapter3.identification.tables import INTERVALS
from avsec_gym.experiments.chapter3.objects.attack_sizes import CAMERA
from avsec_gym.experiments.chapter3.objects.baseline_rates import BaselineSummary
from avsec_gym.experiments.chapter3.objects.believed_points import (
    PASTED,
    PASTED_RAYS_LOST,
    PLANE,
    PLANE_OF_A_CAR,
    PLANE_RAYS_LOST,
)
from avsec_gym.experiments.chapter3.objects.believed_rates import BelievedSummary
from avsec_gym.experiments.chapter3.objects.car_precision import PrecisionAtLevel
from avsec_gym.experiments.chapter3.objects.impact_rates import (
    BogusReturnImpact,
    ImpactSummary,
)
from avsec_gym.experiments.chapter3.objects.score_thresholds import ScoreThreshold
from avsec_gym.experiments.chapter3.objects.sensitivity_curves import SensitivitySummary
from avsec_gym.experiments.chapter3.objects.thesis_of_detectors import (
    FACULA_PRECISION,
    IN_WORDS,
    PRECISION_OF_SIZE,
    TAKEN_FOR_AN_OBSTACLE,
)
from avsec_gym.experiments.chapter3.thesis import OBJECT_LEVEL
from avsec_gym.experiments.chapter5.attack_names import detector_name
from avsec_gym.metrics.average_precision_frames import LEVELS
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.sensor_system import LIDAR

DETECTORS = {
    "pixor": "PIXOR",
    "pointrcnn": "PointRCNN",
    "faster_rcnn": "Faster R-CNN",
    "yolo": "YOLOv3",
}
"""Names of the detectors."""
BELIEVED_IN_WORDS = {
    PLANE: "the thesis’ plane",
    PLANE_RAYS_LOST: "a plane that hides what is behind it",
    PLANE_OF_A_CAR: "the same, as wide as a car’s rear",
    PASTED: "the scan of a car",
    PASTED_RAYS_LOST: "the scan of a car that hides what is behind it",
}
"""Names of the kinds of bogus points."""
ATTACKED = {LIDAR: "a bogus return’s width", CAMERA: "a facula’s radius"}
"""What is varied."""
SHOWN_LEVEL = "moderate"
_METRICS = {"2d": "in the image", "3d": "in 3D"}
_THESIS_RATE = 0.01


@dataclass(frozen=True)
class OpticalSummaries:
    """The results of the experiments on objects; None where a run lacks them.

    Args:
        baseline: Attacks that objects reveal.
        impact: What the thesis' attacks do to detectors.
        believed: The rates at which bogus points are taken for an obstacle.
        sensitivity: What is detected and what harms, by an attack's size.
    """

    baseline: BaselineSummary | None = None
    impact: ImpactSummary | None = None
    believed: BelievedSummary | None = None
    sensitivity: SensitivitySummary | None = None


def tables_of_optical_attacks(summaries: OpticalSummaries) -> list[Table]:
    """The tables that a run has figures of.

    Args:
        summaries: The results of a run.
    """
    tables = []
    if summaries.baseline:
        tables.append(_baseline_table(summaries.baseline))
    if summaries.impact:
        tables += [_impact_table(summaries.impact), _score_table(summaries.impact.lidar)]
    if summaries.believed:
        tables.append(_believed_table(summaries.believed))
    if summaries.sensitivity:
        tables += [_size_table(what, summaries.sensitivity) for what in (LIDAR, CAMERA)]
    return tables


def detector_words(key: str) -> str:
    """The name of a detector in words; a plug-in's own name."""
    return DETECTORS.get(key) or detector_name(key)


def _baseline_table(summary: BaselineSummary) -> Table:
    lines = []
    for row in summary.rows:
        is_of_thesis = row.rate == _THESIS_RATE
        thesis = OBJECT_LEVEL[row.scenario, row.iou] if is_of_thesis else None
        rule = "any" if row.rate is None else f"r = {100 * row.rate:g} %"
        lines.append(
            [
                name(row.scenario),
                name(f"{row.iou:g}"),
                name(rule),
                figure(row.most, digits=0),
                figure(row.rates.average, row.rates.interval, thesis, scale=100, digits=2),
                _share(row.rates.false_alarms),
            ]
        )
    return Table(
        "Table 3.1, baseline: attacks that objects reveal, mean over the seven attack cases",
        ["sensors", "IoU", "alarm", "mismatches without one", "detected, %", "false alarms, %"],
        lines,
        f"A mismatch: a box of one sensor without partner in another’s. {_objects(summary)} Alarm:"
        " at any mismatch, or"
        " at more than the share r of clean frames has, on which nothing here is judged. The"
        " thesis, in italics, does not state how many mismatches make an alarm, nor how often it is"
        f" false. {INTERVALS}",
        names=3,
    )


def _impact_table(summary: ImpactSummary) -> Table:
    lidar, camera = summary.lidar, summary.camera
    lines = [
        [
            name(f"{detector_words(lidar.detector)}: an obstacle where the bogus return is"),
            _share(lidar.shares.clean),
            _share(lidar.shares.taken, TAKEN_FOR_AN_OBSTACLE),
            _share(lidar.shares.newly),
        ]
    ]
    if camera:
        for level in LEVELS:
            clean, lit = FACULA_PRECISION if level == SHOWN_LEVEL else (None, None)
            now = camera.attacked[level]
            lines.append(
                [
                    name(f"{detector_words(camera.detector)}: AP under a facula, {level}"),
                    _percent(camera.clean[level], clean),
                    _percent(now, lit),
                    figure(-now.lost, _turned(now.lost_interval), digits=2, signed=True),
                ]
            )
    return Table(
        "What optical attacks do to detectors",
        ["measure", "clean, %", "attacked, %", "by the attack"],
        lines,
        "Bogus returns: share of the frames, by the attack where only the attacked scan has an"
        f" obstacle there; boxes count from a score of {number(lidar.shares.score, digits=2)} on."
        f" {INTERVALS} AP: cars in the left image, IoU 0.5, 11 recall points, by"
        " the attack in percentage points, intervals by bootstrap over drives. The thesis, in"
        " italics, gives its AP without a level of difficulty.",
    )


def _score_table(lidar: BogusReturnImpact) -> Table:
    return Table(
        "Bogus returns taken for an obstacle, by the score from which on a box is one",
        ["score", "clean, %", "attacked, %", "by the attack, %"],
        [
            [name(number(row.score, digits=2)), *map(_share, (row.clean, row.taken, row.newly))]
            for row in lidar.by_score
        ],
        f"By {detector_words(lidar.detector)}. {INTERVALS}",
    )


def _believed_table(summary: BelievedSummary) -> Table:
    lines = []
    for row in summary.rows:
        of_thesis = (row.detector, row.kind) == ("pixor", PLANE)
        lines.append(
            [
                name(detector_words(row.detector)),
                name(BELIEVED_IN_WORDS[row.kind]),
                _share(row.clean),
                _share(row.taken, TAKEN_FOR_AN_OBSTACLE if of_thesis else None),
                _share(row.newly),
            ]
        )
    scores = [
        f"{detector_words(detector)}’s from {_score(point)}"
        for detector, point in summary.objects.items()
    ]
    return Table(
        "Which bogus points are taken for an obstacle?",
        ["detector", "bogus points", "clean, %", "attacked, %", "by the attack, %"],
        lines,
        "All at one place of a frame, 6 to 10 m ahead, a car's nearest side there. Cars: scans"
        " cut out of other frames, of 200 points or more, that show the LiDAR the sides that were"
        " scanned. Boxes count, where that is known from that score on at which a detector finds"
        f" most for its false alarms on the clean frames of other drives, {' and '.join(scores)}"
        f" on. {INTERVALS} In italics: the thesis.",
        names=2,
    )


def _objects(summary: BaselineSummary) -> str:
    """From which scores on boxes count."""
    lidar, camera = (summary.objects[sensor] for sensor in ("lidar", "camera"))
    if lidar.precision is None and camera.precision is None:
        return f"Boxes count from these scores on: {_score(lidar)} and {_score(camera)}."
    return (
        "Boxes count from that score on at which a detector finds most for its false alarms on the"
        f" clean frames that are fitted on: the LiDAR’s from {_score(lidar)}, the images’ from"
        f" {_score(camera)}."
    )


def _score(point: ScoreThreshold) -> str:
    score = number(point.score, digits=2)
    if point.precision is None:
        return score
    right, found = (number(share, 100, 0) for share in (point.precision, point.recall))
    return f"{score} ({right} % of its boxes are right, {found} % of the cars found)"


def _size_table(what: str, summary: SensitivitySummary) -> Table:
    curve, camera = summary.curves[what], what == CAMERA
    detector = detector_words(curve.detector)
    lines = []
    for row in curve.sizes:
        precision = None if row.precision is None else row.precision[SHOWN_LEVEL]
        thesis = PRECISION_OF_SIZE.get((what, row.size))
        areas = (row.area.covered, row.area.changed) if row.area else ()
        lines.append(
            [
                figure(row.size, digits=1) if row.size else name("clean"),
                *(figure(area, scale=100, digits=2) for area in areas),
                *(_share(row.detected[criterion]) for criterion in ("error", "any")),
                _percent(precision, thesis),
                figure(None)
                if precision is None or not row.size
                else figure(precision.lost, precision.lost_interval, digits=2),
            ]
        )
    measured = (
        f"AP: cars by {detector} {_METRICS[curve.metric]}, IoU {curve.iou:g}, {SHOWN_LEVEL},"
        " 11 recall points; losses in percentage points."
        if detector
        else "AP was not measured."
    )
    unit = "px" if camera else "m"
    columns = [f"{'radius' if camera else 'width'}, {unit}"]
    columns += ["disc’s share of the image, %", "visibly changed, %"] if camera else []
    columns += ["detected by E, %", "by all four shares, %", "AP, %", "AP lost"]
    return Table(
        f"Figure {'3.12' if camera else '3.11'}: {ATTACKED[what]}",
        columns,
        lines,
        f"Detected at r = {100 * summary.rate:g} %, by the LiDAR and two cameras; the clean row"
        f" has false alarms. {measured} {INTERVALS} Those of AP are by bootstrap over drives."
        f" {IN_WORDS[what]}",
    )


def _share(share: Share, thesis: float | None = None) -> TableCell:
    return figure(share.rate, share.interval, thesis, scale=100, digits=2)


def _percent(row: PrecisionAtLevel | None, thesis: float | None = None) -> TableCell:
    known = None if thesis is None else 100 * thesis
    if row is None:
        return figure(None, thesis=known, digits=2)
    return figure(row.value, row.interval, known, digits=2)


def _turned(interval: Sequence[float] | None) -> Sequence[float] | None:
    return None if interval is None else (-interval[1], -interval[0])
