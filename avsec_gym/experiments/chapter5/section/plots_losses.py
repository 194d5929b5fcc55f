"""The picture of the answer: what each attack takes of precision, and what of driving safety."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import mean

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
from avsec_gym.experiments.chapter5.losses import LossRow
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
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.scenario.intention import Intention

LossRows = Sequence[LossRow]

SHAPES = {
    **dict.fromkeys(PERTURBATIONS, "circle"),
    **dict.fromkeys(PATCHES, "square"),
    **dict.fromkeys(JOINT_PATCHES, "diamond"),
    **dict.fromkeys(NOISES, "plus"),
    **dict.fromkeys(GREY_PATCHES, "triangle"),
}
"""Shapes of the marks; other attacks are not drawn."""
_MODERATE = LEVELS.index("moderate")
_WIDTH, _HEIGHT = 320, 320
_FRAME = (44.0, 314.0, 276.0, 26.0)
"""Left, right, bottom, top, pixels."""


def draw_losses(attacks: LossRows) -> list[str]:
    """A drawing for each detector, all with the same scales.

    Args:
        attacks: What each attack takes.
    """
    shown = [row for row in attacks if _in_float(row) and row.condition.attack in SHAPES]
    detectors = list(dict.fromkeys(row.condition.detector for row in shown))
    theirs = {name: thesis_losses(name) for name in detectors}
    known = [point for points in theirs.values() for *_, point in points]
    across = _every([row.precision_lost for row in shown]) + [point[0] for point in known]
    upward = _every([row.safety_lost for row in shown]) + [point[1] for point in known]
    x, y = limits(across, least=5), limits(upward, least=5)
    frame = Frame(Scale(*x, _FRAME[0], _FRAME[1]), Scale(*y, _FRAME[2], _FRAME[3]))
    return [
        _draw(name, [row for row in shown if row.condition.detector == name], theirs[name], frame)
        for name in detectors
    ]


def legend(attacks: LossRows) -> list[Key]:
    """The keys of the attacks that are drawn; controls of one kind are one."""
    names = dict.fromkeys(row.condition.attack for row in attacks if _in_float(row))
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


def _draw(
    detector: str, rows: LossRows, theirs: list[tuple[str, float, Point]], frame: Frame
) -> str:
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
        way = [frame.at(_point(row)) for row in rows if row.condition.attack == attack]
        parts.append(polyline(way, f"thin {colour(attack)}"))
    for row in rows:
        across, upward = row.precision_lost.interval, row.safety_lost.interval
        spans = (across and [*map(frame.x, across)], upward and [*map(frame.y, upward)])
        at = frame.at(_point(row))
        parts.append(cross(at, spans[0], spans[1], colour(row.condition.attack)))
    for attack, strength, point in theirs:
        hint = f"Thesis, {attack_name(attack, strength)}: {_said(point)}"
        shape = SHAPES[attack]
        parts.append(
            marker(frame.at(point), shape, f"hollow theirs {colour(attack)}", hint, focus=True)
        )
    for row in rows:
        at, attack, strength = frame.at(_point(row)), row.condition.attack, row.condition.strength
        parts.append(marker(at, SHAPES[attack], colour(attack), _hint(row), focus=True))
        if attack in PERTURBATIONS and strength in (1, STEPS):
            parts.append(text((at[0] + 6, at[1] - 6), f"n {strength:g}", "step"))
    label = f"{detector_name(detector)}: average precision taken against safe driving taken"
    return drawing(_WIDTH, _HEIGHT, parts, label)


def _hint(row: LossRow) -> str:
    name = attack_name(row.condition.attack, row.condition.strength)
    found = [
        f"{words} {number(-lost, signed=True)} {bounds(_negative(estimate.interval))}".strip()
        for words, lost, estimate in zip(
            ("average precision", "safe driving"),
            _point(row),
            (row.precision_lost, row.safety_lost),
            strict=True,
        )
    ]
    return f"{name}: {', '.join(found)}"


def _said(point: Point) -> str:
    precision, safety = (number(-value, signed=True) for value in point)
    return f"average precision {precision}, safe driving {safety}"


def _negative(interval: Sequence[float] | None) -> list[float] | None:
    return None if interval is None else [-interval[1], -interval[0]]


def _point(row: LossRow) -> Point:
    precision, safety = row.precision_lost.value, row.safety_lost.value
    assert precision is not None
    assert safety is not None
    return precision, safety


def _in_float(row: LossRow) -> bool:
    return not row.condition.whole_levels


def _every(losses: Sequence[Estimate]) -> list[float]:
    values = (value for lost in losses for value in (lost.value, *(lost.interval or ())))
    return [value for value in values if value is not None]


def _thesis_safe(detector: str, key: str) -> float:
    return mean(SAFETY[detector, key, intention].safe for intention in Intention)
