"""The thesis' tables 5.1 to 5.7 with our figures, the thesis' beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from avsec_gym.drawing.page_table import Cell, Table, figure, name
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.settings import (
    JOINT_PATCHES,
    PATCHES,
    PERTURBATIONS,
    UNATTACKED,
)
from avsec_gym.experiments.thesis import LEVELS
from avsec_gym.metrics.average_precision_curves import FEWEST_LABELS
from avsec_gym.scenario.intention import Intention

Rows = Sequence[Mapping[str, Any]]
Column = tuple[str, str, float]
"""Detector, attack, strength."""

_RATES = {
    "success_rate": ("Success", "success"),
    "collision_rate": ("Collision", "collision"),
    "safe_driving_rate": ("Safe driving", "safe"),
}
_NOTE = "In brackets: 95 % Wilson intervals. In italics: the thesis."
_GROUPS = {
    "unattacked": "unattacked",
    "same": "patch where the car goes",
    "different": "patch elsewhere",
    "specific": "specific patch",
}


def tables_of_thesis(report: Mapping[str, Any]) -> list[Table]:
    """Those that the run has figures for.

    Args:
        report: As `avsec_gym.report.run_report.run_report` makes it.
    """
    safety = [row for row in report.get("safety", ()) if not row["whole_levels"]]
    precision = [row for row in report.get("precision", ()) if not row["whole_levels"]]
    tables = [
        _safety_table(
            f"Table {number}: driving safety under {attack_name(attack)}", safety, [attack]
        )
        for number, attack in zip(("5.1", "5.2"), PERTURBATIONS, strict=True)
    ]
    tables += [
        _precision_table(
            "Figure 5.3: average precision under the thesis' PGD", precision, PERTURBATIONS
        ),
        _precision_table("Table 5.3: average precision under patches", precision, PATCHES),
        _safety_table("Table 5.4: driving safety under patches", safety, PATCHES),
        _intention_table(report.get("intentions", ()), "patch-random"),
        _planner_table(report.get("planners", ())),
        _input_table(report.get("inputs", ())),
        _precision_table("Section 5.5.2: average precision, one patch for both detectors",
                         precision, JOINT_PATCHES),
        _safety_table("Section 5.5.2: driving safety, one patch for both detectors",
                      safety, JOINT_PATCHES),
    ]  # fmt: skip
    return [table for table in tables if table is not None]


def _safety_table(title: str, rows: Rows, attacks: Sequence[str]) -> Table | None:
    found = {(*_column(row), row["intention"]): row for row in rows}
    columns = _columns(rows, attacks)
    if not columns:
        return None
    lines = [
        [
            name(words if intention == Intention.LEFT else ""),
            name(str(intention)),
            *(_safety_cell(found[*column, str(intention)], rate, key) for column in columns),
        ]
        for rate, (words, key) in _RATES.items()
        for intention in Intention
    ]
    return Table(
        f"{title}, %",
        [
            "rate",
            "intention",
            *(_heading(attack, strength, attacks) for _, attack, strength in columns),
        ],
        lines,
        _NOTE,
        _detector_groups(columns, 2),
        names=2,
    )


def _safety_cell(row: Mapping[str, Any], rate: str, key: str) -> Cell:
    thesis = None if row["thesis"] is None else row["thesis"][key]
    paired, hint = row["paired"], f"{row['scenarios']} scenarios"
    if paired is not None and row["attack"] != UNATTACKED:
        change = figure(paired[rate], paired[f"{rate}_interval"], scale=100, signed=True)
        hint += f"; to unattacked {change.text} {change.interval}"
        if paired["mcnemar_p"] is not None:
            hint += (
                f"; {paired['became_unsafe']} became unsafe, {paired['became_safe']} safe,"
                f" p = {paired['mcnemar_p']:.2g}"
            )
    return figure(row[rate], row[f"{rate}_interval"], thesis, scale=100, hint=hint)


def _precision_table(title: str, rows: Rows, attacks: Sequence[str]) -> Table | None:
    found = {(*_column(row), row["intention"]): row for row in rows}
    columns = [
        (*column, intention)
        for column in _columns(rows, attacks)
        for intention in (None, *map(str, Intention))
        if (*column, intention) in found
    ]
    if not any(attack in attacks for _, attack, *_ in columns):
        return None
    lines = []
    for points in ("ap11", "ap40"):
        for place, level in enumerate(LEVELS):
            cells = [_precision_cell(found[column], points, place) for column in columns]
            lines.append([name(points.upper() if not place else ""), name(level), *cells])
    loose = [_loose_cell(found[column]) for column in columns]
    lines.append([name("AP11, IoU 0.5"), name("moderate"), *loose])
    headings = [
        _heading(attack, strength, attacks) + (f", {intention}" if intention else "")
        for _, attack, strength, intention in columns
    ]
    return Table(
        f"{title}, cars in 3D at IoU 0.7, %",
        ["points", "level", *headings],
        lines,
        "In brackets: 95 % bootstrap intervals over scenarios. In italics: the thesis."
        + _ceiling(found[columns[0]]),
        _detector_groups([column[:3] for column in columns], 2),
        names=2,
    )


def _ceiling(row: Mapping[str, Any]) -> str:
    """How many cars count, and what perfect detections of them reach."""
    if "labels" not in row:  # Summaries of earlier releases.
        return ""
    parts = [
        f"{count} {level} ({ap11:.1f} and {ap40:.1f})"
        for level, count, (ap11, ap40) in zip(LEVELS, row["labels"], row["ceiling"], strict=True)
    ]
    few = min(row["labels"]) < FEWEST_LABELS
    return (
        f" Cars that count, and what perfect detections of them reach in AP11 and AP40:"
        f" {', '.join(parts)}."
        + (f" With fewer than {FEWEST_LABELS} no detector reaches 100." if few else "")
    )


def _precision_cell(row: Mapping[str, Any], points: str, place: int) -> Cell:
    ours = row["precision"]["3d"]
    interval = ours[f"{points}_interval"][place]
    thesis = row["thesis"][place] if row["thesis"] and points == "ap11" else None
    return figure(
        ours[points][place],
        None if interval is None or interval[0] is None else interval,
        None if thesis is None else 100 * thesis,
    )


def _loose_cell(row: Mapping[str, Any]) -> Cell:
    return figure(row["precision_iou_0.5"]["3d"]["ap11"][LEVELS.index("moderate")])


def _intention_table(rows: Rows, attack: str) -> Table | None:
    found = {(row["detector"], row["group"]): row for row in rows if row["attack"] == attack}
    columns = [
        (detector, group)
        for detector in dict.fromkeys(detector for detector, _ in found)
        for group in _GROUPS
        if (detector, group) in found
    ]
    if not columns:
        return None
    lines = []
    for rate, (words, key) in _RATES.items():
        cells = []
        for column in columns:
            row = found[column]
            thesis = None if row["thesis"] is None else row["thesis"][key]
            hint = f"{row['scenarios']} drives"
            cells.append(figure(row[rate], row[f"{rate}_interval"], thesis, scale=100, hint=hint))
        lines.append([name(words), *cells])
    return Table(
        "Table 5.5: the random patch by where it stands, %",
        ["rate", *(_GROUPS[group] for _, group in columns)],
        lines,
        f"The three intentions together. {_NOTE}",
        _detector_groups([(detector, "", 0) for detector, _ in columns], 1),
    )


def _planner_table(rows: Rows) -> Table | None:
    names = {"astar": "A*", "gbfs": "GBFS"}
    found = {(row["planner"], row["intention"]): row for row in rows}
    planners = [one for one in names if any(planner == one for planner, _ in found)]
    if not planners:
        return None
    return Table(
        "Table 5.6: safe driving on the ground truth by search, %",
        ["intention", *(names[planner] for planner in planners)],
        [
            [name(str(way)), *(_safe_cell(found[planner, str(way)]) for planner in planners)]
            for way in Intention
        ],
        _NOTE,
    )


def _input_table(rows: Rows) -> Table | None:
    found = {
        (row["detector"], row["attack"], row["strength"], row["intention"]): row for row in rows
    }
    columns = list(dict.fromkeys(key[:3] for key in found))
    if len(columns) < 2:
        return None
    headings = [
        "ground truth" if detector is None else attack_name(attack, strength)
        for detector, attack, strength in columns
    ]
    return Table(
        "Table 5.7: safe driving by what the planner is given, %",
        ["intention", *headings],
        [
            [name(str(way)), *(_safe_cell(found[*column, str(way)]) for column in columns)]
            for way in Intention
        ],
        _NOTE,
        _detector_groups([(detector or "", "", 0) for detector, *_ in columns], 1),
    )


def _safe_cell(row: Mapping[str, Any]) -> Cell:
    return figure(
        row["safe_driving_rate"],
        row["safe_driving_rate_interval"],
        row["thesis"],
        scale=100,
        hint=f"{row['scenarios']} scenarios",
    )


def _heading(attack: str, strength: float, attacks: Sequence[str]) -> str:
    """Short: what the title says already is left out."""
    if attack in PERTURBATIONS:
        alpha = attack_name(attack).removeprefix("thesis PGD ")
        words = f"n {strength:g}" if len(attacks) == 1 else f"{alpha}, n {strength:g}"
        return words.replace("n ", "n\N{NO-BREAK SPACE}").replace("α ", "α\N{NO-BREAK SPACE}")
    return attack_name(attack).removesuffix(" patch").removesuffix(" joint")


def _columns(rows: Rows, attacks: Sequence[str]) -> list[Column]:
    """Unattacked first, detector by detector; nothing where none of the attacks was made."""
    every = list(dict.fromkeys(_column(row) for row in rows))
    detectors = {detector for detector, attack, _ in every if attack in attacks}
    return [
        column for column in every if column[0] in detectors and column[1] in (UNATTACKED, *attacks)
    ]


def _column(row: Mapping[str, Any]) -> Column:
    return row["detector"], row["attack"], row["strength"]


def _detector_groups(columns: Sequence[Column], before: int) -> list[tuple[str, int]]:
    """A heading above the columns of each detector."""
    names = [detector for detector, *_ in columns]
    return [("", before)] + [
        (detector_name(detector), names.count(detector)) for detector in dict.fromkeys(names)
    ]
