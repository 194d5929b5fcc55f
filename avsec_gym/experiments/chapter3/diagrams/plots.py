"""Small multiples of what is detected, named and believed, with the thesis' figures marked."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from avsec_gym.drawing.page_figure import Figure, line_key, mark_key
from avsec_gym.drawing.page_plots import Frame, Point, Scale, drawing, marker, polyline, text
from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.drawing.small_panel import HEIGHT, WIDTH, X_ENDS, Y_ENDS
from avsec_gym.experiments.chapter3.diagrams.object_rates import ObjectRates
from avsec_gym.experiments.chapter3.diagrams.summary import (
    LIKELIHOOD,
    DiagramRow,
    DiagramsSummary,
)
from avsec_gym.experiments.chapter3.diagrams.thesis_marks import (
    holds,
    thesis_believed,
    thesis_detected,
    thesis_named,
)
from avsec_gym.experiments.chapter3.diagrams.variant import (
    CAMERA,
    FORMS,
    LIGHTS,
    Variant,
    is_of_lidar,
)
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.sensor_system import LIDAR

RULE_LINES = {"error": "dashed line-0", "any": "line-0", LIKELIHOOD: "line-1"}
"""Class names by rule."""
RULE_WORDS = {
    "error": "E alone (the thesis’)",
    "any": "all four shares",
    LIKELIHOOD: "maximum likelihood",
}
FORM_LINES = dict(zip(FORMS, ("line-0", "line-1", "line-2"), strict=True))
MATCHER_WORDS = {
    "sgbm": "SGBM",
    "sgbm_filled": "SGBM, holes filled",
    "psmnet": "PSMNet, small",
    "psmnet_published": "PSMNet, published",
}
"""Names of matchers."""
DETECTOR_WORDS = {"pixor": "PIXOR", "pointrcnn": "PointRCNN"}
BEAMS = "beams"
"""As many points as the LiDAR's own beams meet."""
_MARK = "hollow theirs line-2"
_AXES = {LIDAR: "points of the bogus object", CAMERA: "peak of the light, grey levels"}


class Curve(NamedTuple):
    """A line of a panel."""

    kind: str
    words: str
    shares: Mapping[float, Share]
    """Shares by the variants' amount."""
    thesis: float | None = None
    """The thesis' figure, marked where the intervals of this line hold it."""


class ShownShare(NamedTuple):
    """What of the rows a figure shows."""

    words: str
    of: Callable[[DiagramRow], Mapping[str, Share]]
    thesis: Callable[[Variant], float | None]


DETECTED = ShownShare(
    "detected by LiDAR and two cameras", lambda row: row.detected, thesis_detected
)
NAMED = ShownShare("named of four sensors", lambda row: row.named, thesis_named)


def figures_of_diagrams(summary: DiagramsSummary) -> list[Figure]:
    """All diagrams of a run.

    Args:
        summary: The results of a run.
    """
    figures = [
        figure
        for shown in (DETECTED, NAMED)
        for figure in (*_figures_of_objects(summary, shown), *_figures_of_lights(summary, shown))
    ]
    return figures + ([_figure_of_beliefs(summary.objects)] if summary.objects else [])


def _figures_of_objects(summary: DiagramsSummary, shown: ShownShare) -> list[Figure]:
    """A figure for each scan, with a panel for each matcher and form."""
    rows = [row for row in summary.attacks if is_of_lidar(row.variant)]
    figures = []
    for scan in dict.fromkeys(row.variant.scan for row in rows):
        panels = [
            _rules_panel(f"{MATCHER_WORDS[matcher]}: {FORMS[form]}", LIDAR, chosen, shown)
            for matcher in summary.frames
            for form in FORMS
            if (
                chosen := [
                    row for row in rows
                    if (row.matcher, row.variant.kind, row.variant.scan) == (matcher, form, scan)
                ]
            )
        ]  # fmt: skip
        title = f"Bogus objects {shown.words}, %, {scan_words(scan)}"
        figures.append(_figure(title, panels, columns=len({row.variant.kind for row in rows})))
    return figures


def _figures_of_lights(summary: DiagramsSummary, shown: ShownShare) -> list[Figure]:
    """A figure for each light, with a panel for each matcher and size."""
    rows = [row for row in summary.attacks if not is_of_lidar(row.variant)]
    figures = []
    for light in dict.fromkeys(row.variant.kind for row in rows):
        sizes = sorted({row.variant.size for row in rows})
        panels = [
            _rules_panel(
                f"{MATCHER_WORDS[matcher]}: {number(size, 100, 1)} % wide", CAMERA, chosen, shown
            )
            for matcher in summary.frames
            for size in sizes
            if (
                chosen := [
                    row for row in rows
                    if (row.matcher, row.variant.kind, row.variant.size) == (matcher, light, size)
                ]
            )
        ]  # fmt: skip
        title = f"{LIGHTS[light]} lights {shown.words}, %, by their radius in shares of the width"
        figures.append(_figure(title, panels, columns=len(sizes)))
    return figures


def _figure(title: str, panels: Sequence[str], columns: int) -> Figure:
    legend = [line_key(kind, RULE_WORDS[rule]) for rule, kind in RULE_LINES.items()]
    legend.append(mark_key(_MARK, "where the thesis’ figure lies", "diamond"))
    return Figure(
        title,
        panels,
        legend,
        note="A diamond: the thesis’ figure, at r = 1 %, where the interval of E alone holds it, in"
        " the panels of attacks that it has: a plane, a Gaussian light of 15 to 30 % of the width."
        " No diamond in such a panel: it lies nowhere.",
        columns=columns,
    )


def _figure_of_beliefs(objects: ObjectRates) -> Figure:
    """A panel for each detector and scan."""
    panels = []
    for detector in dict.fromkeys(row.detector for row in objects.believed):
        rows = [row for row in objects.believed if row.detector == detector]
        for scan in dict.fromkeys(row.variant.scan for row in rows):
            chosen = [row for row in rows if row.variant.scan == scan]
            curves = [
                Curve(
                    kind,
                    FORMS[form],
                    {row.variant.amount: row.taken for row in chosen if row.variant.kind == form},
                    next(
                        (thesis_believed(row.variant, detector) for row in chosen
                         if row.variant.kind == form), None,
                    ),
                )
                for form, kind in FORM_LINES.items()
            ]  # fmt: skip
            title = f"{DETECTOR_WORDS.get(detector, detector)}, {scan_words(scan)}"
            panels.append(_panel(title, LIDAR, curves))
    legend = [line_key(kind, FORMS[form]) for form, kind in FORM_LINES.items()]
    return Figure(
        "Bogus objects that are taken for obstacles, %",
        panels,
        [*legend, mark_key(_MARK, "where the thesis’ 98.6 % lies", "diamond")],
        note="The thesis’ figure is PIXOR’s, of a plane.",
    )


def _rules_panel(title: str, sensor: str, rows: Sequence[DiagramRow], shown: ShownShare) -> str:
    curves = [
        Curve(
            kind,
            RULE_WORDS[rule],
            {row.variant.amount: shown.of(row)[rule] for row in rows},
            shown.thesis(rows[0].variant) if rule == "error" else None,
        )
        for rule, kind in RULE_LINES.items()
    ]
    return _panel(title, sensor, curves)


def _panel(title: str, sensor: str, curves: Sequence[Curve]) -> str:
    """Curves over amounts, which stand at equal distances in their order; beams stand first."""
    amounts = sorted({amount for curve in curves for amount in curve.shares})
    frame = Frame(Scale(-0.3, len(amounts) - 0.7, *X_ENDS), Scale(0, 100, *Y_ENDS))
    parts = [
        frame.axes([], frame.y.ticks(4)),
        text((frame.x.start, 14), title, "name"),
        text(((frame.x.start + frame.x.end) / 2, HEIGHT - 2), _AXES[sensor], "middle"),
    ]
    for place, amount in enumerate(amounts):
        words = BEAMS if not amount else number(amount, digits=0)
        parts.append(text((frame.x(place), frame.y.start + 15), words, "tick middle"))
    marks = []
    for curve in curves:
        points: list[Point] = []
        for place, amount in enumerate(amounts):
            share = curve.shares.get(amount)
            if share is None or share.interval is None:
                continue
            at = frame.at((place, share.percent))
            points.append(at)
            interval = bounds([100 * bound for bound in share.interval])
            hint = f"{curve.words}, {number(share.percent)} {interval} of {share.of}"
            marks.append(marker(at, "circle", f"small {curve.kind.split()[-1]}", hint))
            if curve.thesis is not None and holds(share, curve.thesis):
                there = frame.at((place, 100 * curve.thesis))
                words = f"The thesis: {number(curve.thesis, 100, 2)}"
                marks.append(marker(there, "diamond", _MARK, words))
        parts.append(polyline(points, curve.kind))
    label = f"{title}: percent over the {_AXES[sensor]}"
    return drawing(WIDTH, HEIGHT, [*parts, *marks], label)


def scan_words(scan: int) -> str:
    """How much of the scan is left."""
    return f"a scan of up to {scan:,} points" if scan else "the whole scan"
