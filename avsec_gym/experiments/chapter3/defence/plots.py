"""What a defence is worth: how many episodes are safe, undefended and with each response."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_figure import Figure, mark_key
from avsec_gym.drawing.page_plots import Frame, Scale, drawing, marker, text
from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter3.defence.defended_episodes import NO_ATTACK, UNDEFENDED
from avsec_gym.experiments.chapter3.defence.rates import ANY_ATTACK, DefenceRow
from avsec_gym.experiments.chapter3.defence.tables import attacked_sensors, defended_detector
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.response import Response

MARKS: dict[str, tuple[str, str, str]] = {
    UNDEFENDED: ("circle", "hollow line-1", "undefended"),
    Response.DROP: ("square", "line-0", "drops compromised sensors"),
    Response.REPAIR: ("diamond", "line-2", "repairs them"),
    Response.STOP: ("triangle", "line-1", "stops"),
}
"""Shape, class names, and what the car does."""
_WIDTH, _HEIGHT = 400, 220
_COLUMN = 54
"""Pixels of an attack, at least."""
_BESIDE = 0.18
"""How far the marks of one attack are apart, of the way to the next attack."""


def draw_defence(worth: Sequence[DefenceRow]) -> list[str]:
    """A drawing for each detector.

    Args:
        worth: The rows of `avsec_gym.experiments.chapter3.defence.rates.defence_rows`.
    """
    rows = [row for row in worth if row.attack != ANY_ATTACK]
    return [
        _draw(detector, [row for row in rows if row.detector == detector])
        for detector in dict.fromkeys(row.detector for row in rows)
    ]


def figure_of_defence(worth: Sequence[DefenceRow]) -> Figure:
    """A drawing for each detector, with its legend.

    Args:
        worth: The rows of `avsec_gym.experiments.chapter3.defence.rates.defence_rows`.
    """
    return Figure(
        "Episodes that are safe, by the attacked sensor and the response to an alarm, %",
        draw_defence(worth),
        [mark_key(kind, words, shape) for shape, kind, words in MARKS.values()],
        "Safe: the goal is reached without a collision; a car that stops reaches none.",
        layout="maps",
        label="Safe episodes",
    )


def _draw(detector: str, rows: Sequence[DefenceRow]) -> str:
    attacks = list(dict.fromkeys(row.attack for row in rows))
    width = max(_WIDTH, 46 + _COLUMN * len(attacks))
    frame = Frame(Scale(-0.5, len(attacks) - 0.5, 38, width - 8), Scale(0, 100, _HEIGHT - 26, 26))
    several = any("+" in attack for attack in attacks)
    parts = [
        frame.axes([], frame.y.ticks(5)),
        text((frame.x.start, 14), defended_detector(detector), "name"),
    ]
    for place, attack in enumerate(attacks):
        at = frame.x(place), _HEIGHT - 8
        # Where several are attacked at once, numbers have to do.
        short = attack.replace(LIDAR, "LiDAR") if several and attack != NO_ATTACK else ""
        parts.append(text(at, short or attacked_sensors(attack), "tick middle"))
    for row in rows:
        shape, kind, words = MARKS[row.response]
        beside = _BESIDE * (list(MARKS).index(row.response) - (len(MARKS) - 1) / 2)
        x, rate = attacks.index(row.attack) + beside, row.rates.safe_driving_rate
        hint = f"{attacked_sensors(row.attack)} attacked, {words}: {number(rate, 100)} % safe"
        parts.append(marker(frame.at((x, 100 * rate)), shape, kind, hint))
    label = f"{defended_detector(detector)}: safe episodes in percent, by the attacked sensor"
    return drawing(width, _HEIGHT, parts, label)
