"""Figures 5.3 and 5.4: precision and driving safety over the steps of a perturbation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from avsec_gym.drawing.page_plots import Frame, Scale, band, drawing, limits, marker, polyline, text
from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.settings import PERTURBATIONS, STEPS, UNATTACKED
from avsec_gym.experiments.thesis import LEVELS
from avsec_gym.scenario.intention import Intention

Rows = Sequence[Mapping[str, Any]]
Figure = tuple[float | None, Sequence[float] | None, float | None]
"""Ours, its interval, the thesis'; percent."""

RATES = {
    "safe_driving_rate": "safe driving rate",
    "success_rate": "success rate",
    "collision_rate": "collision rate",
}
"""Columns of safety rows, and what they are called."""
_FAR_ABOVE = 30.0
_WIDTH, _HEIGHT = 250, 190
_FRAME = (34.0, 240.0, 160.0, 26.0)


def draw_precision(rows: Rows) -> list[str]:
    """Average precision over n: a drawing for each detector and alpha, a line for each level."""

    def figure(row: Mapping[str, Any], level: str) -> Figure:
        place = LEVELS.index(level)
        ours, thesis = row["precision"]["3d"], row["thesis"]
        interval = ours["ap11_interval"][place]
        known = None if interval is None or interval[0] is None else interval
        return ours["ap11"][place], known, None if thesis is None else 100 * thesis[place]

    return _draw_all(rows, LEVELS, figure, lambda row, line: True)


def draw_safety(rows: Rows, rate: str) -> list[str]:
    """A rate over n: a drawing for each detector and alpha, a line for each intention."""
    short = {"safe_driving_rate": "safe", "success_rate": "success", "collision_rate": "collision"}

    def figure(row: Mapping[str, Any], intention: str) -> Figure:
        value, interval = row[rate], row[f"{rate}_interval"]
        thesis = None if row["thesis"] is None else 100 * row["thesis"][short[rate]]
        percent = None if interval is None else [100 * bound for bound in interval]
        return None if value is None else 100 * value, percent, thesis

    lines = [str(intention) for intention in Intention]
    return _draw_all(rows, lines, figure, lambda row, line: row["intention"] == line)


def _draw_all(
    rows: Rows,
    lines: Sequence[str],
    figure: Callable[[Mapping[str, Any], str], Figure],
    belongs: Callable[[Mapping[str, Any], str], bool],
) -> list[str]:
    panels: dict[tuple[str, str], dict[str, dict[int, Figure]]] = {}
    for row in rows:
        if row["whole_levels"] or row["attack"] not in (UNATTACKED, *PERTURBATIONS):
            continue
        attacks = PERTURBATIONS if row["attack"] == UNATTACKED else (row["attack"],)
        for attack in attacks:
            panel = panels.setdefault((row["detector"], attack), {line: {} for line in lines})
            for line in lines:
                if belongs(row, line):
                    panel[line][int(row["strength"])] = figure(row, line)
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
    detector: str, attack: str, panel: Mapping[str, Mapping[int, Figure]], frame: Frame
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
                marks.append(marker(frame.at((n, value)), "circle", f"hollow {kind}", hint))
        way = [(n, value) for n, (value, _, _) in known.items() if value is not None]
        parts.append(polyline([frame.at(point) for point in way], kind))
        for n, value in way:
            hint = f"{line}, n {n}: {number(value)} {bounds(known[n][1])}"
            if points[n][2] is not None:
                hint += f"; thesis {number(points[n][2])}"
            marks.append(marker(frame.at((n, value)), "circle", f"small {kind}", hint))
    return drawing(_WIDTH, _HEIGHT, [*parts, *marks], title)


def _steps(panel: Mapping[str, Mapping[int, Figure]]) -> set[int]:
    return {n for points in panel.values() for n in points}


def _limits(values: Sequence[float]) -> tuple[float, float]:
    """From zero, unless everything is far above."""
    low, high = limits(values, least=5)
    if min(values) > _FAR_ABOVE:
        low = 10 * (min(values) // 10)
    return low, min(high, 100.0)
