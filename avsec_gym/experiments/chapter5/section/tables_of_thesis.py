"""The thesis' tables 5.1 to 5.7 with our figures, the thesis' beside them."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import Table, TableCell, figure, name
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.figures import ChapterFigures
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.settings import (
    JOINT_PATCHES,
    PATCHES,
    PERTURBATIONS,
    UNATTACKED,
)
from avsec_gym.experiments.chapter5.tables import (
    InputRow,
    PlacementRow,
    PlannerRow,
    PrecisionRow,
    SafetyRow,
)
from avsec_gym.experiments.thesis import LEVELS, ThesisRates
from avsec_gym.metrics.average_precision_curves import FEWEST_LABELS
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.scenario.intention import Intention

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


def tables_of_thesis(figures: ChapterFigures) -> list[Table]:
    """The tables that the run has figures for."""
    attacks = figures.of_attacks
    safety = [row for row in attacks.safety if not row.condition.whole_levels] if attacks else []
    precision = (
        [row for row in attacks.precision if not row.condition.whole_levels] if attacks else []
    )
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
        _placement_table(attacks.placements if attacks else (), "patch-random"),
        _planner_table(figures.planners),
        _input_table(attacks.inputs if attacks else ()),
        _precision_table("Section 5.5.2: average precision, one patch for both detectors",
                         precision, JOINT_PATCHES),
        _safety_table("Section 5.5.2: driving safety, one patch for both detectors",
                      safety, JOINT_PATCHES),
    ]  # fmt: skip
    return [table for table in tables if table is not None]


def _safety_table(title: str, rows: Sequence[SafetyRow], attacks: Sequence[str]) -> Table | None:
    found = {(*_column(row.condition), row.intention): row for row in rows}
    columns = _columns([row.condition for row in rows], attacks)
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


def _safety_cell(row: SafetyRow, rate: str, key: str) -> TableCell:
    paired, hint = row.paired, f"{row.rates.scenarios} scenarios"
    if paired is not None and row.condition.attack != UNATTACKED:
        difference = vars(paired)[rate]
        change = figure(difference.value, difference.interval, scale=100, signed=True)
        hint += f"; to unattacked {change.text} {change.interval}"
        if paired.mcnemar_p is not None:
            hint += (
                f"; {paired.became_unsafe} became unsafe, {paired.became_safe} safe,"
                f" p = {paired.mcnemar_p:.2g}"
            )
    return _rate_cell(row.rates, rate, _thesis(row.thesis, key), hint)


def _rate_cell(rates: SafetyRates, rate: str, thesis: float | None, hint: str) -> TableCell:
    known = rates.to_json()
    return figure(known[rate], known[f"{rate}_interval"], thesis, scale=100, hint=hint)


def _thesis(rates: ThesisRates | None, key: str) -> float | None:
    return None if rates is None else float(vars(rates)[key])


def _precision_table(
    title: str, rows: Sequence[PrecisionRow], attacks: Sequence[str]
) -> Table | None:
    found = {(*_column(row.condition), row.intention): row for row in rows}
    columns = [
        (*column, intention)
        for column in _columns([row.condition for row in rows], attacks)
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


def _ceiling(row: PrecisionRow) -> str:
    """How many cars count, and what perfect detections of them reach."""
    parts = [
        f"{count} {level} ({ap11:.1f} and {ap40:.1f})"
        for level, count, (ap11, ap40) in zip(LEVELS, row.labels, row.ceiling, strict=True)
    ]
    few = min(row.labels) < FEWEST_LABELS
    return (
        f" Cars that count, and what perfect detections of them reach in AP11 and AP40:"
        f" {', '.join(parts)}."
        + (f" With fewer than {FEWEST_LABELS} no detector reaches 100." if few else "")
    )


def _precision_cell(row: PrecisionRow, points: str, place: int) -> TableCell:
    ours = row.precision["3d"]
    interval = ours[f"{points}_interval"][place]
    thesis = row.thesis[place] if row.thesis and points == "ap11" else None
    return figure(
        ours[points][place],
        None if interval is None or interval[0] is None else interval,
        None if thesis is None else 100 * thesis,
    )


def _loose_cell(row: PrecisionRow) -> TableCell:
    return figure(row.precision_iou_low["3d"]["ap11"][LEVELS.index("moderate")])


def _placement_table(rows: Sequence[PlacementRow], attack: str) -> Table | None:
    found = {
        (row.condition.detector, row.group): row for row in rows if row.condition.attack == attack
    }
    columns = [
        (detector, group)
        for detector in dict.fromkeys(detector for detector, _ in found)
        for group in _GROUPS
        if (detector, group) in found
    ]
    if not columns:
        return None
    lines = [
        [
            name(words),
            *(
                _rate_cell(
                    row.rates, rate, _thesis(row.thesis, key), f"{row.rates.scenarios} episodes"
                )
                for row in (found[column] for column in columns)
            ),
        ]
        for rate, (words, key) in _RATES.items()
    ]
    return Table(
        "Table 5.5: the random patch by where it stands, %",
        ["rate", *(_GROUPS[group] for _, group in columns)],
        lines,
        "The three intentions together. In brackets: 95 % intervals, Wilson’s, widened by what the"
        " episodes of one scene share. In italics: the thesis.",
        _detector_groups([(detector, "", 0) for detector, _ in columns], 1),
    )


def _planner_table(rows: Sequence[PlannerRow]) -> Table | None:
    names = {"astar": "A*", "gbfs": "GBFS"}
    found = {(row.planner, row.intention): row for row in rows}
    planners = [planner for planner in names if any(planner == known for known, _ in found)]
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


def _input_table(rows: Sequence[InputRow]) -> Table | None:
    found = {(row.detector, row.attack, row.strength, row.intention): row for row in rows}
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


def _safe_cell(row: PlannerRow | InputRow) -> TableCell:
    hint = f"{row.rates.scenarios} scenarios"
    return _rate_cell(row.rates, "safe_driving_rate", row.thesis, hint)


def _heading(attack: str, strength: float, attacks: Sequence[str]) -> str:
    """Short: the words of the title are left out."""
    if attack in PERTURBATIONS:
        alpha = attack_name(attack).removeprefix("thesis PGD ")
        words = f"n {strength:g}" if len(attacks) == 1 else f"{alpha}, n {strength:g}"
        return words.replace("n ", "n\N{NO-BREAK SPACE}").replace("α ", "α\N{NO-BREAK SPACE}")
    return attack_name(attack).removesuffix(" patch").removesuffix(" joint")


def _columns(conditions: Sequence[Condition], attacks: Sequence[str]) -> list[Column]:
    """Unattacked first, detector by detector; nothing where none of the attacks was made."""
    every = list(dict.fromkeys(_column(condition) for condition in conditions))
    detectors = {detector for detector, attack, _ in every if attack in attacks}
    return [
        column for column in every if column[0] in detectors and column[1] in (UNATTACKED, *attacks)
    ]


def _column(condition: Condition) -> Column:
    return condition.detector, condition.attack, condition.strength


def _detector_groups(columns: Sequence[Column], before: int) -> list[tuple[str, int]]:
    """A heading above the columns of each detector."""
    names = [detector for detector, *_ in columns]
    return [("", before)] + [
        (detector_name(detector), names.count(detector)) for detector in dict.fromkeys(names)
    ]
