"""The picture of the answer: what each attack takes of precision, and what of driving safety."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import mean
from typing import Any

from avsec_gym.drawing.page_figure import Key, mark_key
from avsec_gym.drawing.page_plots import (
    Frame,
    Point,
    Scale,
    cross,
    drawing,
    limits,
    marker,
    polyline,
    text,
)
from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.settings import (
    GREY_PATCHES,
    JOINT_PATCHES,
    NOISES,
    PATCHES,
    PERTURBATIONS,
    STEPS,
    UNATTACKED,
    specific,
    thesis_setting,
)
from avsec_gym.experiments.thesis import LEVELS, PRECISION, SAFETY
from avsec_gym.scenario.intention import Intention

Rows = Sequence[Mapping[str, Any]]

SHAPES = {
    **dict.fromkeys(PERTURBATIONS, "circle"),
    **dict.fromkeys(PATCHES, "square"),
    **dict.fromkeys(JOINT_PATCHES, "diamond"),
    **dict.fromkeys(NOISES, "plus"),
    **dict.fromkeys(GREY_PATCHES, "triangle"),
}
"""Of the marks; other attacks are not drawn."""
_MODERATE = LEVELS.index("moderate")
_WIDTH, _HEIGHT = 320, 320
_FRAME = (44.0, 314.0, 276.0, 26.0)
"""Left, right, bottom, top, pixels."""


def draw_losses(attacks: Rows) -> list[str]:
    """A drawing for each detector, all with the same scales.

    Args:
        attacks: The rows ``attacks`` of `avsec_gym.experiments.chapter5.decoupling.decoupling`.
    """
    shown = [row for row in attacks if row["attack"] in SHAPES and not row["whole_levels"]]
    detectors = list(dict.fromkeys(row["detector"] for row in shown))
    theirs = {name: thesis_losses(name) for name in detectors}
    known = [point for points in theirs.values() for *_, point in points]
    x = limits(_every(shown, "precision") + [point[0] for point in known], least=5)
    y = limits(_every(shown, "safety") + [point[1] for point in known], least=5)
    frame = Frame(Scale(*x, _FRAME[0], _FRAME[1]), Scale(*y, _FRAME[2], _FRAME[3]))
    return [
        _draw(name, [row for row in shown if row["detector"] == name], theirs[name], frame)
        for name in detectors
    ]


def legend(attacks: Rows) -> list[Key]:
    """The keys of the attacks that are drawn; controls of one kind are one."""
    names = dict.fromkeys(row["attack"] for row in attacks if not row["whole_levels"])
    entries = {}
    for attack in names:
        if attack in SHAPES:
            kind = attack.partition("-")[0]
            words = {"noise": "noise (control)", "grey": "grey disc (control)"}
            entries[words.get(kind, attack_name(attack))] = attack
    return [mark_key(colour(attack), words, SHAPES[attack]) for words, attack in entries.items()]


def thesis_losses(detector: str) -> list[tuple[str, float, Point]]:
    """Attack, strength, and what it takes, where the thesis gives both as numbers; points."""
    found = []
    for attack in PERTURBATIONS + PATCHES:
        for strength in range(1, STEPS + 1) if attack in PERTURBATIONS else (0,):
            key = thesis_setting(attack, strength)
            names = [key] if (detector, key) in PRECISION else [specific(key, i) for i in Intention]
            if all((detector, name) in PRECISION for name in names):
                left = mean(PRECISION[detector, name][_MODERATE] for name in names)
                lost = PRECISION[detector, UNATTACKED][_MODERATE] - left
                safe = _thesis_safe(detector, UNATTACKED) - _thesis_safe(detector, key)
                found.append((attack, float(strength), (100 * lost, 100 * safe)))
    return found


def colour(attack: str) -> str:
    """The class name that gives an attack its colour."""
    return f"of-{attack.replace('.', '-')}"


def _draw(detector: str, rows: Rows, theirs: list[tuple[str, float, Point]], frame: Frame) -> str:
    parts = [frame.axes(frame.x.ticks(), frame.y.ticks())]
    parts.append(text((frame.x.start, 14), detector_name(detector), "name"))
    middle = (frame.x.start + frame.x.end) / 2
    parts.append(text((middle, _HEIGHT - 8), "average precision taken, points", "axis middle"))
    y = (frame.y.start + frame.y.end) / 2
    parts.append(
        f'<g transform="rotate(-90 12 {y:g})">'
        f"{text((12, y), 'safe driving taken, points', 'axis middle')}</g>"
    )
    for attack in PERTURBATIONS:
        way = [frame.at(_point(row)) for row in rows if row["attack"] == attack]
        parts.append(polyline(way, f"thin {colour(attack)}"))
    for row in rows:
        across, upward = (row[f"{what}_lost_interval"] for what in ("precision", "safety"))
        spans = (across and [*map(frame.x, across)], upward and [*map(frame.y, upward)])
        parts.append(cross(frame.at(_point(row)), spans[0], spans[1], colour(row["attack"])))
    for attack, strength, point in theirs:
        hint = f"Thesis, {attack_name(attack, strength)}: {_said(point)}"
        shape = SHAPES[attack]
        parts.append(marker(frame.at(point), shape, f"hollow {colour(attack)}", hint, focus=True))
    for row in rows:
        at = frame.at(_point(row))
        kind, shape = colour(row["attack"]), SHAPES[row["attack"]]
        parts.append(marker(at, shape, kind, _hint(row), focus=True))
        if row["attack"] in PERTURBATIONS and row["strength"] in (1, STEPS):
            parts.append(text((at[0] + 6, at[1] - 6), f"n {row['strength']:g}", "step"))
    label = f"{detector_name(detector)}: average precision taken against safe driving taken"
    return drawing(_WIDTH, _HEIGHT, parts, label)


def _hint(row: Mapping[str, Any]) -> str:
    name = attack_name(row["attack"], row["strength"])
    found = [
        f"{words} {number(-row[f'{what}_lost'], signed=True)} "
        f"{bounds(_negative(row[f'{what}_lost_interval']))}".strip()
        for what, words in (("precision", "average precision"), ("safety", "safe driving"))
    ]
    return f"{name}: {', '.join(found)}"


def _said(point: Point) -> str:
    precision, safety = (number(-value, signed=True) for value in point)
    return f"average precision {precision}, safe driving {safety}"


def _negative(interval: Sequence[float] | None) -> list[float] | None:
    return None if interval is None else [-interval[1], -interval[0]]


def _point(row: Mapping[str, Any]) -> Point:
    return row["precision_lost"], row["safety_lost"]


def _every(rows: Rows, what: str) -> list[float]:
    return [
        value
        for row in rows
        for value in (row[f"{what}_lost"], *(row[f"{what}_lost_interval"] or ()))
    ]


def _thesis_safe(detector: str, key: str) -> float:
    return mean(SAFETY[detector, key, intention].safe for intention in Intention)
