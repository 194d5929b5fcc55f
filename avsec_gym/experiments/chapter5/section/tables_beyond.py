"""Tables beyond the thesis': losses, what is seen, controls, rounding, flips."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from avsec_gym.drawing.page_table import UNKNOWN, Cell, Table, figure, name, number, p_value
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.settings import UNATTACKED

Rows = Sequence[Mapping[str, Any]]
_POINTS = "In percentage points; in brackets: 95 % bootstrap intervals over scenarios."


def loss_table(rows: Rows) -> Table:
    """What every attack takes, and which drives it turns."""
    lines = []
    for row in rows:
        paired = row["paired"]
        lines.append(
            [
                *_names(row),
                figure(row["precision_lost"], row["precision_lost_interval"]),
                figure(row["safety_lost"], row["safety_lost_interval"]),
                _count(paired.get("became_unsafe")),
                _count(paired.get("became_safe")),
                _count(paired.get("drives")),
            ]
        )
    return Table(
        "What each attack takes",
        ["detector", "attack", "AP taken", "safe driving taken", "became unsafe", "became safe",
         "drives"],
        lines,
        "AP: cars in 3D, IoU 0.7, moderate, 11 recall points. Safe driving: the three intentions"
        f" together. {_POINTS}",
        names=2, sortable=True, filters=(0,),
    )  # fmt: skip


def paired_table(rows: Rows) -> Table:
    """Safe driving under each attack against unattacked, scenario by scenario."""
    lines = [
        [
            *_names(row),
            name(row["intention"]),
            figure(
                paired["safe_driving_rate"],
                paired["safe_driving_rate_interval"],
                scale=100,
                signed=True,
            ),
            _count(paired["became_unsafe"]),
            _count(paired["became_safe"]),
            Cell(p_value(paired["mcnemar_p"]), key=paired["mcnemar_p"]),
        ]
        for row in rows
        for paired in [row["paired"]]
        if paired is not None and row["attack"] != UNATTACKED
    ]
    return Table(
        "Paired tests: the same scenarios, unattacked and attacked",
        ["detector", "attack", "intention", "safe driving, change", "became unsafe", "became safe",
         "p"],
        lines,
        "p: McNemar’s exact test, two-sided, not corrected for the number of rows. Change in"
        " percentage points; in brackets: 95 % bootstrap intervals over scenarios.",
        names=3, sortable=True, filters=(0, 2), folded=True,
    )  # fmt: skip


def seen_table(rows: Rows) -> Table:
    """Why: cars that are still found, ghosts in the driven lanes and beside them."""
    lines = [
        [
            *_names(row),
            figure(row["cars_found"], row["cars_found_interval"], scale=100),
            figure(row["ghosts_in_lanes"], row["ghosts_in_lanes_interval"], digits=2),
            figure(row["ghosts_beside"], row["ghosts_beside_interval"], digits=2),
        ]
        for row in rows
    ]
    return Table(
        "Why: what is seen under attack",
        ["detector", "attack", "cars found, %", "ghosts in the three lanes", "ghosts beside them"],
        lines,
        "Found: a detection that is planned on overlaps the car by more than half, from above."
        " Ghosts overlap nothing real; counts are for each scenario. The car drives in the three"
        " lanes only. In brackets: 95 % bootstrap intervals over scenarios.",
        names=2,
    )


def patch_effect_table(rows: Rows) -> Table:
    """Why: how often the ghost of a patch is seen, and what it does then."""
    lines = [
        [
            *_names(row),
            _count(row["drives"]),
            *(
                figure(row[name], row[f"{name}_interval"], scale=100)
                for name in ("seen", "unsafe_seen", "unsafe_unseen")
            ),
        ]
        for row in rows
    ]
    return Table(
        "Why: ghosts of patches, and what they do",
        ["detector", "attack", "drives", "ghost seen, %", "unsafe if seen, %",
         "unsafe if not seen, %"],
        lines,
        "Of the drives that are safe unattacked. A ghost is seen where the planner gets a box that"
        " meets it on the ground, as a real object there may: the grey disc tells how often. In"
        " brackets: 95 % intervals by bootstrap over scenarios, whose drives belong together;"
        " Wilson’s where no drive counts or all do.",
        names=2,
    )  # fmt: skip


def control_table(rows: Rows) -> Table:
    """The sanity sheet."""
    aims = {"up": "raises", "down": "lowers", None: "control"}
    towards = {"ghosts": "to its ghosts", "truth": "to the truth"}
    lines = []
    for row in rows:
        share = figure(row["share_moved"], row["share_moved_interval"], scale=100)
        budget = UNKNOWN if row["budget"] is None else f"{row['budget']:g}"
        lines.append(
            [
                *_names(row),
                name(f"{towards[row['loss_towards']]}, {aims[row['aim']]}" if row["loss_towards"]
                     else "not measured"),
                figure(row["loss_before"], digits=3),
                figure(row["loss_after"], digits=3),
                share,
                figure(row.get("ghosts_seen"), row.get("ghosts_seen_interval"), scale=100),
                figure(row["largest_change"], digits=2),
                Cell(budget, tone="" if row["within_budget"] else "bad",
                     hint="" if row["within_budget"] else "exceeded"),
            ]
        )  # fmt: skip
    return Table(
        "Sanity sheet: losses and budgets",
        ["detector", "attack", "loss", "median before", "median after", "moved that way, %",
         "ghost seen, %", "largest change", "budget"],
        lines,
        "A perturbation is to raise the loss against the truth, a patch to lower that towards its"
        " ghosts b*; controls should do neither as much. Grey levels. A patch may change anything"
        " inside its disc; its ghost is seen where the planner gets a box that meets it on the"
        " ground, as a real object at the same place may. In brackets: 95 % Wilson intervals.",
        names=2,
    )  # fmt: skip


def trend_table(rows: Rows) -> Table:
    """Slopes over n."""
    lines = [
        [
            *_names(row),
            figure(row["precision_slope"], row["precision_slope_interval"], signed=True),
            figure(row["safety_slope"], row["safety_slope_interval"], signed=True),
        ]
        for row in rows
    ]
    return Table(
        "Trend with strength: change with each step n",
        ["detector", "attack", "average precision", "safe driving"],
        lines,
        f"Slopes of straight lines over n = 0 to 4. {_POINTS}",
        names=2,
    )


def rounding_table(rows: Rows) -> Table:
    """8 bits against float."""
    lines = []
    for row in rows:
        cells = []
        for what in ("precision", "safety"):
            cells += [
                figure(row[f"{what}_float"]),
                figure(row[f"{what}_8_bit"]),
                figure(row[f"{what}_difference"], row[f"{what}_difference_interval"], signed=True),
            ]
        lines.append([*_names(row), *cells])
    return Table(
        "Whole grey levels: 8 bits against float",
        ["detector", "attack", *("float", "8 bits", "difference") * 2],
        lines,
        "Attacked pixels rounded once, at the end, as a camera’s bus would carry them. One step of"
        f" 0.4 grey levels vanishes. {_POINTS}",
        [("", 2), ("average precision, %", 3), ("safe driving, %", 3)],
        names=2,
    )


def flip_table(rows: Rows) -> Table:
    """Drives that were safe and are not: one row for all strengths of an attack."""
    drives: dict[tuple[str, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        if not row["whole_levels"]:
            key = (row["detector"], row["attack"], row["scenario"], row["intention"])
            drives.setdefault(key, []).append(row)
    lines, tones = [], {"collision": "bad", "unplanned": "warn"}
    for (detector, attack, scenario, intention), found in drives.items():
        steps = ", ".join(f"{row['strength']:g}" for row in found if row["strength"])
        last = found[-1]
        lines.append(
            [
                name(detector_name(detector)),
                name(attack_name(attack)),
                name(scenario),
                name(intention),
                name(steps if "pgd" in attack else ""),
                Cell(last["outcome"], tone=tones[last["outcome"]], words=True),
                name(last["why"]),
            ]
        )
    return Table(
        "Flips: safe unattacked, unsafe under attack",
        ["detector", "attack", "scene", "intention", "n", "became", "why"],
        lines,
        "At the largest n where there are several. Attacks in 8 bits are in the JSON only.",
        names=7, sortable=True, filters=(0, 1, 3, 5),
    )  # fmt: skip


def _names(row: Mapping[str, Any]) -> list[Cell]:
    attack = attack_name(row["attack"], row.get("strength", 0), row.get("whole_levels", False))
    return [name(detector_name(row["detector"])), name(attack)]


def _count(value: int | None) -> Cell:
    return Cell(UNKNOWN) if value is None else Cell(number(value, digits=0), key=value)
