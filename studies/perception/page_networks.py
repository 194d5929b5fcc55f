"""Parts of detectors.md on real frames, disparity, time, driving, parity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from avsec_gym.experiments.json_rows import row_of
from avsec_gym.metrics.disparity_errors import ErrorRate
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.report.markdown_table import UNKNOWN, interval, markdown_table, number
from studies.perception.disparity_accuracy import MATCHING, DisparityAccuracy
from studies.perception.real_frames import DetectorsInRealFrames, FrameCounts

_ESTIMATORS = {
    "psmnet_small": "PSMNet, small",
    "psmnet_medium": "PSMNet, medium",
    "sgbm_reduced": "SGBM at the small PSMNet's input size",
    "sgbm": "SGBM at the camera's size",
}


@dataclass(frozen=True)
class DetectorTime:
    """What a detector costs; seconds."""

    parameters: int
    detect: float
    pixel_gradient: float
    training_per_image: float


@dataclass(frozen=True)
class DetectorTimes:
    """The result of ``benchmarks/detectors.py``."""

    threads: int
    frames: int
    detectors: Mapping[str, DetectorTime]

    @classmethod
    def from_json(cls, found: Mapping[str, Any]) -> DetectorTimes:
        """The detectors stand among the two numbers."""
        rows = {name: row for name, row in found.items() if isinstance(row, Mapping)}
        return cls(
            found["threads"],
            found["frames"],
            {name: row_of(DetectorTime, row) for name, row in rows.items()},
        )


@dataclass(frozen=True)
class RankedDetector:
    """A row of `detector_ranking`."""

    detector: str
    safe_driving_rate: float
    interval: tuple[float, float]
    collisions: int
    unplanned: int
    found: float
    """The share of the objects that are found."""
    lead: float | None = None
    """Its rate less that of the one behind it, in the same episodes; None of the last."""
    lead_interval: tuple[float, ...] = ()


def real(result: DetectorsInRealFrames) -> list[str]:
    """The section of `real_frames`."""
    rows = []
    for name, figures in result.detectors.items():
        for id, frame in figures.frames.items():
            sure = [number(found.score, 2) for found in frame.surest[:3]]
            counts = _real_counts(frame.total)
            rows.append([f"`{name}`", id, str(len(frame.cars)), *counts, ", ".join(sure)])
        rows.append([f"`{name}`", "all", "", *_real_counts(figures.all), ""])
    least = ", ".join(
        f"`{name}` {figures.least_score:.2f}" for name, figures in result.detectors.items()
    )
    return [
        "## Real frames, out of domain",
        "",
        "The networks have seen rendered images only. Four real frames say little of how well they"
        " do on real roads, and that is how this table is meant: by boxes from these scores,"
        f" {least}, the moderate cars seen in the image, found (IoU 0.5 from above) and missed."
        " Every car and the surest detections are in [real_frames.json](real_frames.json); KITTI's"
        " photographs may not be shown here, the command writes them with boxes to `runs/`:",
        "",
        "```",
        "python -m studies.perception.real_frames --kitti ROOT"
        " --precision studies/results/detectors.json",
        "```",
        "",
        *markdown_table(
            ["detector", "frame", "cars", "to find", "seen", "found", "missed", "false alarms",
             "highest scores"],
            rows,
        ),
        "",
        "![Real frames from above](images/real_frames.png)",
    ]  # fmt: skip


def _real_counts(frames: FrameCounts) -> list[str]:
    counts = frames.counts
    numbers = (frames.to_find, frames.seen_in_image, counts.found, counts.missed)
    return [*map(str, numbers), str(counts.false_alarms)]


def disparity(result: DisparityAccuracy) -> list[str]:
    """The section of `disparity_accuracy`."""
    parts = {}
    if result.world:
        parts[f"{result.world.pairs} held-out pairs, dense truth"] = result.world
    parts |= {f"{name}, one real pair": figures for name, figures in (result.real or {}).items()}
    sizes = [f"{width} x {height}" for height, width in result.input_sizes.values()]
    lines = [
        "## Disparity",
        "",
        "End-point error in pixels of the camera's image; wrong: off by more than 3 pixels, and"
        " (D1) by more than 5 % as well, in percent. *Found*: the pixels where an estimator gives"
        " something; *all*: every pixel with truth, occluded ones among them, holes filled as"
        " KITTI's development kit fills them. Both presets of PSMNet have the same weights and"
        f" reduce images to {' and '.join(sizes)} pixels. Intervals (95 %) by"
        " bootstrap over pairs; real pairs are out of PSMNet's domain.",
        "",
        "```",
        "python -m studies.perception.disparity_accuracy --world HELD_OUT --kitti ROOT",
        "```",
    ]
    for title, part in parts.items():
        rows = [
            [
                _ESTIMATORS[name],
                _rate(figures.rates.density, 100),
                *(
                    _rate(rate, scale)
                    for pixels in (figures.rates.found, figures.rates.all)
                    for rate, scale in (
                        (pixels.end_point_error, 1),
                        (pixels.off_3px, 100),
                        (pixels.d1, 100),
                    )
                ),
                number(figures.seconds, 2),
            ]
            for name, figures in part.estimators.items()
        ]
        lines += ["", f"**{title}** (time on {part.threads} threads)", ""]
        lines += markdown_table(
            ["estimator", "found, %", "found: error, px", "> 3 px, %", "D1, %", "all: error, px",
             "> 3 px, %", "D1, %", "s a pair"],
            rows,
        )  # fmt: skip
        lines += ["", "Where semi-global matching at the camera's size finds something:", ""]
        lines += markdown_table(
            ["estimator", "error, px", "> 3 px, %", "D1, %", "> 3 px more than SGBM, points"],
            [
                [
                    _ESTIMATORS[name],
                    _rate(figures.where_matched.end_point_error, 1),
                    _rate(figures.where_matched.off_3px, 100),
                    _rate(figures.where_matched.d1, 100),
                    _points(figures.more_wrong) if name != MATCHING else UNKNOWN,
                ]
                for name, figures in part.estimators.items()
            ],
        )
    return lines


def seconds(result: DetectorTimes) -> list[str]:
    """The section of ``benchmarks/detectors.py``."""
    return [
        "## Time",
        "",
        f"Seconds, median over {result.frames} frames of 1242 x 375 pixels on"
        f" {result.threads} threads of a shared machine, by `python benchmarks/detectors.py`: a"
        " frame from decoded images to boxes; the gradient of the loss down to the pixels (a step"
        " of an attack); training, for each image.",
        "",
        *markdown_table(
            ["detector", "parameters", "a frame", "pixel gradient", "training, an image"],
            [
                [
                    f"`{name}`",
                    f"{time.parameters:,}",
                    number(time.detect, 2),
                    number(time.pixel_gradient, 2),
                    number(time.training_per_image, 2),
                ]
                for name, time in result.detectors.items()
            ],
        ),
    ]


def ranking(rows: Sequence[RankedDetector]) -> list[str]:
    """The section of `detector_ranking`."""
    return [
        "## Who drives safely",
        "",
        "`avsec/DetectorBenchmark-v0` on the default suite `mixed` with judging assets (its"
        " layouts, with other assets, were validation frames of some of the first trainings), the"
        " same episodes for every detector, by `python -m studies.detector_ranking`; rates in"
        " percent with 95 % intervals over scenes. The lead is on the one behind, in the same"
        " episodes. `nothing` reports no object.",
        "",
        *_ranked(rows),
    ]


def contested(rows: Sequence[RankedDetector]) -> list[str]:
    """The section of `contested_ranking`."""
    return [
        "Where a car that sees nothing drives unsafely, and one that sees everything does not"
        " (`mixed_contested` with judging assets, `python -m studies.contested_ranking`):",
        "",
        *_ranked(rows),
    ]


def _ranked(rows: Sequence[RankedDetector]) -> list[str]:
    return markdown_table(
        ["detector", "safe driving", "lead", "collisions", "without a plan", "objects found"],
        [
            [
                f"`{row.detector}`",
                interval(100 * row.safe_driving_rate, [100 * bound for bound in row.interval]),
                "–"
                if row.lead is None
                else interval(100 * row.lead, [100 * bound for bound in row.lead_interval]),
                str(row.collisions),
                str(row.unplanned),
                number(100 * row.found, 1),
            ]
            for row in rows
        ],
    )


def parity(result: Mapping[str, Mapping[str, float]]) -> list[str]:
    """The section of ``benchmarks/parity.py``."""
    return [
        "## The full networks against the originals",
        "",
        "Largest error of any output relative to its largest value, with weights filled by one"
        " rule, by `python -m benchmarks.parity DIR --json`; the bound is 1e-3.",
        "",
        *markdown_table(
            ["network", "outputs", "largest error"],
            [
                [f"`{name}`", str(len(errors)), f"{max(errors.values()):.1e}"]
                for name, errors in result.items()
            ],
        ),
    ]


def _points(difference: Estimate) -> str:
    """A difference of shares, and its interval, in percentage points."""
    if difference.value is None:
        return UNKNOWN
    bounds = difference.interval and [100 * bound for bound in difference.interval]
    return interval(100 * difference.value, bounds, 2)


def _rate(rate: ErrorRate, scale: float) -> str:
    scaled = None if rate.value is None else scale * rate.value
    bounds = rate.interval and [scale * bound for bound in rate.interval]
    return interval(scaled, bounds, 1 if scale > 1 else 2)
