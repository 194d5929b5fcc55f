"""Figures 3.11 and 3.12: what is detected, and what a detector still finds, by an attack's size."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from avsec_gym.drawing.page_figure import Figure, line_key, mark_key
from avsec_gym.drawing.page_plots import Frame, Scale, band, drawing, marker, polyline, text
from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter3.objects.attack_sizes import CAMERA
from avsec_gym.experiments.chapter3.objects.sensitivity_curves import (
    SensitivityCurve,
    SensitivitySummary,
    SizeRow,
)
from avsec_gym.experiments.chapter3.objects.tables import SHOWN_LEVEL, detector_words
from avsec_gym.experiments.chapter3.objects.thesis_of_detectors import PRECISION_OF_SIZE
from avsec_gym.sensor_system import LIDAR

Percent = tuple[float, Sequence[float] | None]
"""Percent, and its interval."""

CURVES = {
    "line-0": "detected (all four shares)",
    "dashed line-0": "detected by E alone",
    "line-1": "the detector’s AP",
}
"""What lines are of, for a legend."""
_WIDTH, _HEIGHT = 400, 240
_AXES = {LIDAR: "width of the bogus return, m", CAMERA: "facula’s share of the image, %"}


def draw_sensitivity(summary: SensitivitySummary) -> list[str]:
    """A drawing for the LiDAR and one for the camera.

    Args:
        summary: The results of a run.
    """
    return [_draw(what, curve) for what, curve in summary.curves.items()]


def figure_of_sensitivity(summary: SensitivitySummary) -> Figure:
    """Both drawings, with their legend.

    Args:
        summary: The results of a run.
    """
    legend = [line_key(kind, words) for kind, words in CURVES.items()]
    return Figure(
        "Figures 3.11 and 3.12: what is detected, and what a detector still finds, %",
        draw_sensitivity(summary),
        [*legend, mark_key("hollow theirs line-1", "AP in the thesis", size=4)],
        layout="maps",
        label="Figures 3.11 and 3.12",
    )


def _draw(what: str, curve: SensitivityCurve) -> str:
    rows = curve.sizes
    places = [100 * row.area.covered if row.area else row.size for row in rows]
    room = 0.02 * max(places)
    frame = Frame(Scale(-room, max(places) + room, 38, _WIDTH - 8), Scale(0, 100, _HEIGHT - 38, 26))
    detector = detector_words(curve.detector)
    words = f"{'LiDAR' if what == LIDAR else 'Camera'} attacked{f', {detector}' * bool(detector)}"
    parts = [
        frame.axes(frame.x.ticks(6), frame.y.ticks(5)),
        text((frame.x.start, 14), words, "name"),
        text(((frame.x.start + frame.x.end) / 2, _HEIGHT - 6), _AXES[what], "middle"),
    ]
    marks: list[str] = []
    curves: dict[str, Callable[[SizeRow], Percent | None]] = {
        "dashed line-0": lambda row: _detected(row, "error"),
        "line-0": lambda row: _detected(row, "any"),
        "line-1": _precision,
    }
    for kind, of in curves.items():
        known = [(x, row, of(row)) for x, row in zip(places, rows, strict=True)]
        points = [(x, row, percent) for x, row, percent in known if percent is not None]
        spans = [(x, percent[1]) for x, _, percent in points if percent[1] is not None]
        if kind != "dashed line-0":
            low, high = ([frame.at((x, span[side])) for x, span in spans] for side in (0, 1))
            parts.append(band(low, high, kind))
        parts.append(polyline([frame.at((x, percent[0])) for x, _, percent in points], kind))
        for x, row, (value, interval) in points:
            size = f"{row.size:g} {'px' if what == CAMERA else 'm'}" if row.size else "clean"
            hint = f"{CURVES[kind]}, {size}: {number(value)} {bounds(interval)}"
            marks.append(marker(frame.at((x, value)), "circle", f"small {kind.split()[-1]}", hint))
    for x, row in zip(places, rows, strict=True):
        thesis = PRECISION_OF_SIZE.get((what, row.size))
        if thesis is not None:
            hint = f"The thesis’ AP: {number(thesis, 100, 2)}"
            marks.append(
                marker(frame.at((x, 100 * thesis)), "circle", "hollow theirs line-1", hint)
            )
    label = f"{words}: what is detected, and AP, in percent, over the attack’s size"
    return drawing(_WIDTH, _HEIGHT, [*parts, *marks], label)


def _detected(row: SizeRow, criterion: str) -> Percent | None:
    share = row.detected[criterion]
    if share.interval is None:
        return None
    return share.percent, [100 * bound for bound in share.interval]


def _precision(row: SizeRow) -> Percent | None:
    if row.precision is None:
        return None
    found = row.precision[SHOWN_LEVEL]
    return found.value, found.interval
