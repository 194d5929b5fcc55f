"""Small drawings of chapter 4: steps of a distribution, lines, and points with intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avsec_gym.drawing.page_plots import (
    Frame,
    Point,
    band,
    cross,
    drawing,
    marker,
    polyline,
)
from avsec_gym.drawing.small_panel import HEIGHT, WIDTH, Y_ENDS, panel_axes, panel_frame

_SIZE = 2.5
"""Pixels from points of one value to those of the next kind."""


@dataclass(frozen=True)
class Mark:
    """A point that can be pointed at.

    Args:
        at: Where it is, in figures.
        kind: Class names.
        hint: What is shown when a pointer rests on it.
        interval: Low and high of its y; None: none is drawn.
    """

    at: Point
    kind: str
    hint: str
    interval: Sequence[float] | None = None


def steps_panel(
    title: str, below: str, right: float, shown: Mapping[str, Sequence[float]], bound: float
) -> str:
    """Distributions as steps, percent.

    Args:
        title: The text above the drawing.
        below: The text below its x axis.
        right: Where the last bin ends; the first one begins at 0.
        shown: The share in each of equal bins, by class names.
        bound: Where a dashed line stands.
    """
    highest = max(max(shares) for shares in shown.values())
    frame = panel_frame(right, max(100 * highest, 1.0))
    parts = panel_axes(frame, title, below)
    for kind, shares in shown.items():
        steps = [
            frame.at((right * edge / len(shares), 100 * share))
            for place, share in enumerate(shares)
            for edge in (place, place + 1)
        ]
        floor = [(x, frame.y.start) for x, _ in steps]
        parts += [band(floor, steps, kind), polyline(steps, f"thin {kind}")]
    ends = [(frame.x(bound), end) for end in Y_ENDS]
    parts.append(polyline(ends, "thin dashed of-soft"))
    return drawing(WIDTH, HEIGHT, parts, f"{title}: distribution over {below}")


def lines_panel(
    title: str,
    below: str,
    right: float,
    lines: Mapping[str, Sequence[Point]],
    marks: Sequence[Mark] = (),
) -> str:
    """Rates in percent over something, as lines.

    Args:
        title: The text above the drawing.
        below: The text below its x axis.
        right: Where the x axis ends.
        lines: Points by class names; those beyond the axis are left out.
        marks: Marks above them.
    """
    frame = panel_frame(right, 100.0)
    parts = panel_axes(frame, title, below)
    for kind, points in lines.items():
        within = [point for point in points if point[0] <= right]
        if 0 < len(within) < len(points):  # It goes on beyond the axis.
            within.append((right, within[-1][1]))
        parts.append(polyline([frame.at(point) for point in within], kind))
    parts += _drawn(frame, marks)
    return drawing(WIDTH, HEIGHT, parts, f"{title}: rates over {below}, in percent")


def _drawn(frame: Frame, marks: Sequence[Mark]) -> list[str]:
    parts = []
    for mark in marks:
        # Marks of one value stand side by side, in the order of their kinds.
        kinds = sorted({each.kind for each in marks})
        beside = _SIZE * (2 * kinds.index(mark.kind) - len(kinds) + 1)
        x, y = frame.at(mark.at)
        at = (x + beside, y)
        if mark.interval is not None:
            ends = [frame.y(bound) for bound in mark.interval]
            parts.append(cross(at, None, ends, mark.kind.split()[-1]))
        parts.append(marker(at, "circle", mark.kind, mark.hint))
    return parts
