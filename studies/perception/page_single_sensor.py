"""The part of studies/results/detectors.md on the detectors of one sensor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avsec_gym.report.markdown_table import interval, markdown_table, number
from studies.perception.detection_errors import LEVEL
from studies.perception.detector_scores import Interval
from studies.perception.page_frames import assets_of, held_out, world_make
from studies.perception.single_sensor_precision import (
    DRIVING_SCORE,
    ScoredSensor,
    SingleSensorPrecision,
)
from studies.perception.training_history import Training

_WHERE = {"2d": "in the image", "bev": "from above", "3d": "in space"}


def single_sensor(result: SingleSensorPrecision, known: Sequence[Training] = ()) -> list[str]:
    """The section of `single_sensor_precision`.

    Args:
        result: Its result.
        known: Trainings of the networks, as far as they are known.
    """
    data, rows = result.data, []
    for name, figures in result.detectors.items():
        precision = figures.average_precision
        for metric in next(iter(precision.values())):
            cells = [
                cell
                for values in precision.values()
                for cell in (
                    moderate(values[metric].ap11, values[metric].ap11_interval),
                    moderate(values[metric].ap40, values[metric].ap40_interval),
                )
            ]
            seconds = number(figures.seconds.median, 2)
            rows.append([f"`{name}`", figures.sensor, _WHERE[metric], *cells, seconds])
    ious = next(iter(result.detectors.values())).average_precision
    titles = [f"{points}, IoU {iou}" for iou in ious for points in ("AP11", "AP40")]
    threads = {figures.seconds.threads for figures in result.detectors.values()}
    cards = {name: figures.weights for name, figures in result.detectors.items()}
    made, whose = [], ""
    if data.suite is not None:
        whose = (
            f" of the procedural world (suite `{data.suite}`, seed {data.seed}, {assets_of(data)})"
        )
        made = [f"{world_make(data)} --out DIR"]
    return [
        "## Of one sensor",
        "",
        "The detectors that chapter 3 compares between sensors, on"
        f" {data.frames} frames with scans{whose}, {data.cars.moderate} moderate cars in them."
        f" {held_out(data, cards, known)} Average precision of cars, moderate, with 95 %"
        f" bootstrap intervals over frames ({result.resamples} draws), in what the sensor lets"
        " them tell: PIXOR knows no heights, an image no places. Seconds a frame on"
        f" {' or '.join(map(str, sorted(threads)))} threads. Numbers in"
        " [single_sensor_detectors.json](single_sensor_detectors.json).",
        "",
        "```",
        *made,
        "python -m studies.perception.single_sensor_precision --kitti DIR"
        + " --real ROOT" * any(figures.real for figures in result.detectors.values()),
        "```",
        "",
        *markdown_table(["detector", "sees", "scored", *titles, "s a frame"], rows),
        *_in_real_frames(result.detectors),
    ]


def _in_real_frames(detectors: Mapping[str, ScoredSensor]) -> list[str]:
    rows = [
        [
            f"`{name}`",
            number(figures.working_point.score if figures.working_point else None, 2),
            str(len(real.frames)),
            *map(str, (real.counts.found, real.counts.missed, real.counts.false_alarms)),
            *(
                map(str, (real.driving.found, real.driving.false_alarms))
                if real.driving
                else ("–", "–")
            ),
        ]
        for name, figures in detectors.items()
        if (real := figures.real)
    ]
    if not rows:
        return []
    return [
        "",
        "The networks have learned from the procedural world alone. In the few frames of KITTI at"
        " hand that have labels and the sensor, moderate cars found and missed, and"
        " boxes that are none (IoU 0.5, from above or in the image), from that score on at which"
        " most is found for its false alarms (best F1) in the held-out frames; and from a score of"
        f" {DRIVING_SCORE} on, with which cars drive:",
        "",
        *markdown_table(
            [
                *("detector", "score", "real frames", "found", "missed", "false alarms"),
                *(f"found from {DRIVING_SCORE}", "false alarms"),
            ],
            rows,
        ),
    ]


def moderate(values: Sequence[float | None], bounds: Sequence[Interval] | None) -> str:
    """A precision at the moderate level, with its interval."""
    return interval(values[LEVEL], bounds[LEVEL] if bounds else None)
