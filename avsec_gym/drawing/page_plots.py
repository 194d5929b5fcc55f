"""Parts of line drawings for pages: SVG whose colours are the page's, light or dark.

Marks carry class names, never colours: the style sheet of `report` gives their looks.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

from avsec_gym.drawing.page_table import number

Point = tuple[float, float]


@dataclass(frozen=True)
class Scale:
    """A scale from figures to pixels.

    Args:
        low: Figure at `start`.
        high: Figure at `end`.
        start: The pixel at which the scale starts.
        end: The pixel at which it ends.
    """

    low: float
    high: float
    start: float
    end: float

    def __call__(self, value: float) -> float:
        """Pixels of a figure, within the scale."""
        share = (min(max(value, self.low), self.high) - self.low) / (self.high - self.low)
        return round(self.start + share * (self.end - self.start), 1)

    def ticks(self, count: int = 6) -> list[float]:
        """Round figures within it, about so many."""
        step = _round_step((self.high - self.low) / count)
        first = math.ceil(self.low / step - 1e-9)
        last = math.floor(self.high / step + 1e-9)
        return [n * step for n in range(first, last + 1)]


@dataclass(frozen=True)
class Frame:
    """Where a drawing's figures are.

    Args:
        x: Scale from left to right.
        y: Scale from bottom to top: `start` is the larger number of pixels.
    """

    x: Scale
    y: Scale

    def at(self, point: Point) -> Point:
        """Pixels of a point."""
        return self.x(point[0]), self.y(point[1])

    def axes(self, x_ticks: Sequence[float], y_ticks: Sequence[float]) -> str:
        """Grid lines and their figures; zero is stronger."""
        left, right, bottom, top = self.x.start, self.x.end, self.y.start, self.y.end
        parts = []
        for tick in x_ticks:
            x = self.x(tick)
            parts.append(_line((x, bottom), (x, top), "zero" if abs(tick) < 1e-9 else "grid"))
            parts.append(text((x, bottom + 15), _tick(tick), "tick middle"))
        for tick in y_ticks:
            y = self.y(tick)
            parts.append(_line((left, y), (right, y), "zero" if abs(tick) < 1e-9 else "grid"))
            parts.append(text((left - 6, y + 3.5), _tick(tick), "tick end"))
        return "".join(parts)


def drawing(width: float, height: float, parts: Iterable[str], label: str) -> str:
    """A whole drawing.

    Args:
        width: Width of its own pixels; the drawing is shown as wide as its place on the page, but
            never smaller, so that its words keep the size of the style sheet.
        height: Height of its own pixels.
        parts: What is drawn, from back to front.
        label: A text in place of the drawing for readers who do not see it.
    """
    return (
        f'<svg viewBox="0 0 {width:g} {height:g}" style="min-width:{width:g}px" role="group"'
        f' aria-label="{escape(label)}">'
        f"{''.join(parts)}</svg>"
    )


def text(at: Point, words: str, kind: str = "") -> str:
    """Words; `kind` holds class names, such as ``middle`` or ``end`` for where `at` is."""
    return f'<text x="{at[0]:g}" y="{at[1]:g}" class="{kind}">{escape(words)}</text>'


def polyline(points: Sequence[Point], kind: str) -> str:
    """A line through points."""
    return f'<polyline points="{_places(points)}" class="line {kind}"/>'


def band(low: Sequence[Point], high: Sequence[Point], kind: str) -> str:
    """The area between two lines."""
    return f'<polygon points="{_places([*low, *reversed(high)])}" class="band {kind}"/>'


def cross(at: Point, x: Sequence[float] | None, y: Sequence[float] | None, kind: str) -> str:
    """Intervals of a point, in pixels: low and high in either direction."""
    parts = []
    if x is not None:
        parts.append(_line((x[0], at[1]), (x[1], at[1]), f"interval {kind}"))
    if y is not None:
        parts.append(_line((at[0], y[0]), (at[0], y[1]), f"interval {kind}"))
    return "".join(parts)


def marker(at: Point, shape: str, kind: str, hint: str, *, focus: bool = False) -> str:
    """A mark that can be pointed at.

    Args:
        at: The place of the mark, pixels.
        shape: ``circle``, ``square``, ``diamond``, ``triangle`` or ``plus``.
        kind: Class names; ``hollow`` is not filled, ``small`` is smaller, ``theirs`` goes where a
            reader leaves the thesis' values out.
        hint: The text that is shown where the pointer rests on it.
        focus: Whether it can be reached by keyboard, too.
    """
    x, y = at
    said = escape(hint)
    reached = ' tabindex="0"' if focus else ""
    size = 3.0 if "small" in kind.split() else 4.5
    return (
        f'<g class="mark {kind}" role="img" aria-label="{said}" data-hint="{said}"{reached}>'
        f'<circle cx="{x:g}" cy="{y:g}" r="10" class="reach"/>{mark_shape(at, shape, size)}</g>'
    )


def mark_shape(at: Point, shape: str, size: float = 4.5) -> str:
    """The mark alone."""
    x, y = at
    corners = {
        "square": [(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
        "diamond": [(0, -1.25), (1.25, 0), (0, 1.25), (-1.25, 0)],
        "triangle": [(0, -1.15), (1.1, 0.85), (-1.1, 0.85)],
    }
    if shape in corners:
        places = [(x + size * dx, y + size * dy) for dx, dy in corners[shape]]
        return f'<polygon points="{_places(places)}"/>'
    if shape == "plus":
        return (
            f'<path d="M{x - size:g} {y:g}H{x + size:g}M{x:g} {y - size:g}V{y + size:g}"'
            ' class="stroke"/>'
        )
    return f'<circle cx="{x:g}" cy="{y:g}" r="{size:g}"/>'


def limits(values: Iterable[float | None], least: float = 1.0) -> tuple[float, float]:
    """Limits that hold all values and zero with some room, and are at least so far apart."""
    known = [value for value in values if value is not None] + [0.0]
    low, high = min(known), max(known)
    high = max(high, low + least)
    room = 0.05 * (high - low)
    return low - room, high + room


def _round_step(size: float) -> float:
    """1, 2, 2.5 or 5 times a power of ten, at least as large."""
    power = 10.0 ** math.floor(math.log10(max(size, 1e-12)))
    return next(power * step for step in (1, 2, 2.5, 5, 10) if power * step >= size * (1 - 1e-9))


def _tick(value: float) -> str:
    return number(value, digits=0 if abs(value - round(value)) < 1e-9 else 1)


def _line(start: Point, end: Point, kind: str) -> str:
    return (
        f'<line x1="{start[0]:g}" y1="{start[1]:g}" x2="{end[0]:g}" y2="{end[1]:g}"'
        f' class="{kind}"/>'
    )


def _places(points: Sequence[Point]) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
