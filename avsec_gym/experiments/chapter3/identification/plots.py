"""Disparity errors and the rates that follow from them: figures 3.5 to 3.10 of the thesis.

A reliability diagram of the probabilities, which the thesis does not give, stands beside them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from avsec_gym.drawing.page_figure import Figure, line_key
from avsec_gym.drawing.page_plots import Point, band, drawing, marker, polyline
from avsec_gym.drawing.page_table import number
from avsec_gym.drawing.small_panel import HEIGHT, WIDTH, Y_ENDS, panel_axes, panel_frame
from avsec_gym.experiments.chapter3.identification.calibration import (
    LikelihoodCalibration,
    ReliabilityPoint,
)
from avsec_gym.experiments.chapter3.identification.detection_rates import (
    CaseRates,
    DetectionRateRow,
)
from avsec_gym.experiments.chapter3.identification.error_distributions import (
    BesideBounds,
    ReferenceDistribution,
)
from avsec_gym.experiments.chapter3.identification.identification_rates import MethodRates
from avsec_gym.experiments.chapter3.identification.summary import ValidationSummary
from avsec_gym.experiments.chapter3.identification.tables import CRITERIA, METHODS, error_name
from avsec_gym.experiments.chapter3.thesis import DETECTION, IDENTIFICATION

Lines = Mapping[str, Sequence[Point]]
"""Lines by class names; percent."""

_HOLLOW = "Hollow: the thesis, where it gives a number."
_CLEAN, _ATTACKED = "line-0", "line-1"
_CRITERION_KINDS = {"any": "line-1", "error": "dashed line-1"}
_METHOD_KINDS = {
    "algorithm 2, error": "dashed line-0",
    "algorithm 2, any": "line-0",
    "maximum likelihood": "line-1",
}


def figures_of_validation(summary: ValidationSummary) -> list[Figure]:
    """All of a run.

    Args:
        summary: The results of a run.
    """
    figures = []
    rows = summary.case_distributions
    for (shown, curves), row in zip((("3.5", "3.6"), ("3.7", "3.8")), rows, strict=True):
        panels = [
            _histograms(
                _attacked(case),
                row.largest,
                [("clean", row.clean), (case, shares)],
                row.beside.bounds,
            )
            for case, shares in row.cases.items()
        ]
        title = f"Figure {shown}: disparity error E of {row.scenario}, share of frames in %"
        legend = [line_key(_CLEAN, "not attacked"), line_key(_ATTACKED, "attacked")]
        figures.append(Figure(title, panels, legend, note=_bounds_note(row.beside)))
        detection = [rates for rates in summary.detection if rates.scenario == row.scenario]
        figures.append(_detection_figure(curves, row.scenario, detection))
    figures.append(_reference_figure(summary.reference_distributions))
    figures.append(_identification_figure(summary.identification))
    figures.append(_reliability_figure(summary.calibration))
    return figures


def _detection_figure(figure: str, scenario: str, rows: Sequence[DetectionRateRow]) -> Figure:
    panels = []
    for case in rows[0].rates.cases:
        lines = {
            "thin line-0": _curve(rows, "any", lambda rates: rates.false_alarms.rate),
            **{
                kind: _curve(rows, criterion, _of_case(case))
                for criterion, kind in _CRITERION_KINDS.items()
            },
        }
        panels.append(_curves(_attacked(case), lines))
    mean = {
        kind: _curve(rows, criterion, lambda rates: rates.average)
        for criterion, kind in _CRITERION_KINDS.items()
    }
    of_thesis = [
        (100 * rate, 100 * rated) for (name, rate), rated in DETECTION.items() if name == scenario
    ]
    panels.append(_curves("mean of the seven cases", mean, of_thesis))
    legend = [line_key(kind, CRITERIA[criterion]) for criterion, kind in _CRITERION_KINDS.items()]
    legend.append(line_key("thin line-0", "false alarms, of all four shares"))
    title = f"Figure {figure}: detection rate over r, {scenario}, %"
    return Figure(title, panels, legend, note=_HOLLOW)


def _identification_figure(rows: Sequence[MethodRates]) -> Figure:
    panels = []
    for place, sensor in enumerate(rows[0].rates.sensors):
        lines = {
            kind: [
                (100 * row.rates.rate, row.rates.sensors[sensor].percent)
                for row in rows
                if row.method == method
            ]
            for method, kind in _METHOD_KINDS.items()
        }
        thesis = [(100 * rate, 100 * rates[place]) for rate, rates in IDENTIFICATION.items()]
        panels.append(_curves(_attacked(sensor), lines, thesis))
    legend = [line_key(kind, METHODS[method]) for method, kind in _METHOD_KINDS.items()]
    return Figure(
        "Figure 3.10: identification rate over r, %",
        panels,
        legend,
        note=_HOLLOW,
    )


def _reference_figure(rows: Sequence[ReferenceDistribution]) -> Figure:
    panels = []
    for row in rows:
        name, bounds = error_name(row.triple), row.beside.bounds if row.beside else ()
        for case, shares in row.cases.items():
            touched = case in {f"S{sensor}" for sensor in row.triple}
            title = f"{name}, {_attacked(case)}"
            panels.append(_histograms(title, row.largest, [("clean", shares)], bounds, touched))
    legend = [
        line_key(_CLEAN, "no sensor of the triple attacked"),
        line_key(_ATTACKED, "one of them attacked"),
    ]
    title = "Figure 3.9: disparity errors that the reference is in, share of frames in %"
    notes = [_bounds_note(row.beside, error_name(row.triple)) for row in rows if row.beside]
    return Figure(title, panels, legend, columns=5, note=" ".join(notes))


def _reliability_figure(calibration: LikelihoodCalibration) -> Figure:
    return Figure(
        "Are the probabilities calibrated? Share of sensors that were attacked, %",
        [
            _reliability_panel("by the prior as it comes", calibration.probabilities.reliability),
            _reliability_panel("all states alike", calibration.all_alike.reliability),
        ],
        note="By maximum likelihood, in tenths of P(attacked), with every state as often as the"
        " prior expects it, or all of them equally often, most of them beyond n − 2; on the line,"
        " prediction and observation agree. Whiskers: 95 % intervals, Wilson's, as if drives were"
        " independent;"
        " where few clean frames carry most of the weight, they are wide.",
    )


def _reliability_panel(title: str, points: Iterable[ReliabilityPoint]) -> str:
    frame = panel_frame(100.0, 100.0)
    parts = panel_axes(frame, title, "predicted P(attacked), %")
    parts.append(polyline([frame.at((0, 0)), frame.at((100, 100))], "thin of-soft"))
    for point in points:
        predicted, observed = 100 * point.predicted, 100 * point.observed
        low, high = (100 * bound for bound in point.interval)
        hint = (
            f"predicted {number(predicted)} %, observed {number(observed)} %"
            f" [{number(low)}, {number(high)}];"
            f" {number(100 * point.sensors, digits=2)} % of all sensors"
        )
        parts.append(
            polyline([frame.at((predicted, low)), frame.at((predicted, high))], f"thin {_ATTACKED}")
        )
        parts.append(marker(frame.at((predicted, observed)), "circle", f"small {_ATTACKED}", hint))
    label = f"How often a sensor was attacked, over the predicted probability, {title}"
    return drawing(WIDTH, HEIGHT, parts, label)


def _bounds_note(beside: BesideBounds, name: str = "E") -> str:
    """Where the thesis draws the lines."""
    below, above = (f"{100 * bound:g} %" for bound in beside.bounds)
    return (
        f"Dashed: the thesis finds {name} below {below} in clean frames, above {above} in attacked"
        " ones."
    )


def _histograms(
    title: str,
    largest: float,
    shown: Sequence[tuple[str, Sequence[float]]],
    bounds: Sequence[float] = (),
    touched: bool = False,
) -> str:
    """Steps of one distribution, or of a clean and an attacked one."""
    highest = max(max(shares) for _, shares in shown)
    frame = panel_frame(100 * largest, max(100 * highest, 1.0))
    parts = panel_axes(frame, title, "E, %")
    kinds = (_ATTACKED,) if touched else (_CLEAN, _ATTACKED)
    for kind, (_, shares) in zip(kinds, shown, strict=False):
        steps = [
            frame.at((100 * largest * edge / len(shares), 100 * share))
            for place, share in enumerate(shares)
            for edge in (place, place + 1)
        ]
        floor = [(x, frame.y.start) for x, _ in steps]
        parts += [band(floor, steps, kind), polyline(steps, f"thin {kind}")]
    for bound in bounds:
        if bound <= largest:
            line = [(frame.x(100 * bound), end) for end in Y_ENDS]
            parts.append(polyline(line, "thin dashed of-soft"))
    return drawing(WIDTH, HEIGHT, parts, f"{title}: distribution of the disparity error")


def _curves(title: str, lines: Lines, thesis: Sequence[Point] = ()) -> str:
    frame = panel_frame(100.0, 100.0)
    parts = panel_axes(frame, title, "r, %")
    parts += [
        polyline([frame.at(point) for point in points], kind) for kind, points in lines.items()
    ]
    for rate, share in thesis:
        hint = f"The thesis, r = {rate:g} %: {number(share, digits=2)}"
        parts.append(marker(frame.at((rate, share)), "circle", "hollow small theirs line-0", hint))
    return drawing(WIDTH, HEIGHT, parts, f"{title}: rates over r, in percent")


def _of_case(case: str) -> Callable[[CaseRates], float]:
    return lambda rates: rates.cases[case]


def _curve(
    rows: Iterable[DetectionRateRow], criterion: str, of: Callable[[CaseRates], float | None]
) -> list[Point]:
    """In percent, over r; where there is something to measure."""
    own = [(row.rate, of(row.rates)) for row in rows if row.criterion == criterion]
    return [(100 * rate, 100 * share) for rate, share in own if share is not None]


def _attacked(case: str) -> str:
    return f"{case.replace('+', ', ')} attacked" if case else "no attack"
