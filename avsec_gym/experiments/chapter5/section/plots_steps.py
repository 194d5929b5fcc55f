"""Figures 5.3 and 5.4: precision and driving safety over the steps of a perturbation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avsec_gym.drawing.page_plots import Frame, Scale, band, drawing, limits, marker, polyline, text
from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.settings import PERTURBATIONS, STEPS, UNATTACKED
from avsec_gym.experiments.chapter5.tables import PrecisionRow, SafetyRow
from avsec_gym.experiments.thesis import LEVELS
from avsec_gym.scenario.intention import Intention

PlottedFigure = tuple[float | None, Sequence[float] | None, float | None]
"""Ours, its interval, the thesis'; percent."""


@dataclass(frozen=True)
class PlottedPoint:
    """A figure of one line at one step, percent.

    Args:
        condition: The detector under so many steps.
        line: The line that it belongs to.
        figure: The point's value, interval, and the thesis'.
    """

    condition: Condition
    line: str
    figure: PlottedFigure


RATES = {
    "safe_driving_rate": "safe driving rate",
    "success_rate": "success rate",
    "collision_rate": "collision rate",
}
"""Rates of safety rows, and what they are called."""
_OF_THESIS = {"safe_driving_rate": "safe", "success_rate": "success", "collision_rate": "collision"}
_FAR_ABOVE = 30.0
_WIDTH, _HEIGHT = 250, 190
_FRAME = (34.0, 240.0, 160.0, 26.0)


def draw_precision(rows: Sequence[PrecisionRow]) -> list[str]:
    """Average precision over n: a drawing for each detector and alpha, a line for each level."""
    points = []
    for row in rows:
        ours = row.precision["3d"]
        for place, level in enumerate(LEVELS):
            interval = ours["ap11_interval"][place]
            known = None if interval is None or interval[0] is None else interval
            thesis = None if row.thesis is None else 100 * row.thesis[place]
            points.append(PlottedPoint(row.condition, level, (ours["ap11"][place], known, thesis)))
    return _draw_all(points, LEVELS)


def draw_safety(rows: Sequence[SafetyRow], rate: str) -> list[str]:
    """A rate over n: a drawing for each detector and alpha, a line for each intention.

    Args:
        rows: Rows for all conditions.
        rate: One of `RATES`.
    """
    points = []
    for row in rows:
        rates = row.rates.to_json()
        value, interval = rates[rate], rates[f"{rate}_interval"]
        percent = None if interval is None else [100 * bound for bound in interval]
        thesis = None if row.thesis is None else 100 * vars(row.thesis)[_OF_THESIS[rate]]
        figure = (None if value is None else 100 * value, percent, thesis)
        points.append(PlottedPoint(row.condition, row.intention, figure))
    return _draw_all(points, [str(intention) for intention in Intention])


def _draw_all(all_points: Sequence[PlottedPoint], lines: Sequence[str]) -> list[str]:
    panels: dict[tuple[str, str], dict[str, dict[int, PlottedFigure]]] = {}
    for point in all_points:
        condition = point.condition
        if condition.whole_levels or condition.attack not in (UNATTACKED, *PERTURBATIONS):
            continue
        # The unattacked detector is step 0 of every perturbation.
        attacks = PERTURBATIONS if condition.attack == UNATTACKED else (condition.attack,)
        for attack in attacks:
            panel = panels.setdefault((condition.detector, attack), {line: {} for line in lines})
            panel[point.line][int(condition.strength)] = point.figure
    every = [
        value
        for panel in panels.values()
        for points in panel.values()
        for ours, interval, thesis in points.values()
        for value in (ours, *(interval or ()), thesis)
        if value is not None
    ]
    if not every:
        return []
    frame = Frame(Scale(0, STEPS, _FRAME[0], _FRAME[1]), Scale(*_limits(every), *_FRAME[2:]))
    order = sorted(panels, key=lambda key: (key[0], PERTURBATIONS.index(key[1])))
    return [_draw(*key, panels[key], frame) for key in order if len(_steps(panels[key])) > 1]


def _draw(
    detector: str, attack: str, panel: Mapping[str, Mapping[int, PlottedFigure]], frame: Frame
) -> str:
    title = f"{detector_name(detector)}, {attack_name(attack)}"
    parts = [frame.axes(range(STEPS + 1), frame.y.ticks(4))]
    parts.append(text((frame.x.start, 14), title, "name"))
    middle = (frame.x.start + frame.x.end) / 2
    parts.append(text((middle, _HEIGHT - 2), "steps n", "middle"))
    marks = []
    for number_, (line, points) in enumerate(panel.items()):
        kind = f"line-{number_}"
        known = {n: one for n, one in sorted(points.items()) if one[0] is not None}
        spans = {n: interval for n, (_, interval, _) in known.items() if interval is not None}
        low, high = (
            [frame.at((n, interval[side])) for n, interval in spans.items()] for side in (0, 1)
        )
        parts.append(band(low, high, kind))
        theirs = [(n, one[2]) for n, one in sorted(points.items()) if one[2] is not None]
        if len(theirs) > 2:
            parts.append(polyline([frame.at(point) for point in theirs], f"dashed {kind}"))
        else:
            for n, value in theirs:
                hint = f"Thesis, {line}, n {n}: {number(value)}"
                marks.append(marker(frame.at((n, value)), "circle", f"hollow theirs {kind}", hint))
        way = [(n, value) for n, (value, _, _) in known.items() if value is not None]
        parts.append(polyline([frame.at(point) for point in way], kind))
        for n, value in way:
            hint = f"{line}, n {n}: {number(value)} {bounds(known[n][1])}"
            if points[n][2] is not None:
                hint += f"; thesis {number(points[n][2])}"
            marks.append(marker(frame.at((n, value)), "circle", f"small {kind}", hint))
    return drawing(_WIDTH, _HEIGHT, [*parts, *marks], title)


def _steps(panel: Mapping[str, Mapping[int, PlottedFigure]]) -> set[int]:
    return {n for points in panel.values() for n in points}


def _limits(values: Sequence[float]) -> tuple[float, float]:
    """From zero, unless everything is far above."""
    low, high = limits(values, least=5)
    if min(values) > _FAR_ABOVE:
        low = 10 * (min(values) // 10)
    return low, min(high, 100.0)
