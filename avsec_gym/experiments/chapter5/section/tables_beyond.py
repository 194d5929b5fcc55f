"""Tables beyond the thesis': losses, what is seen, controls, rounding, flips."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import UNKNOWN, Table, TableCell, figure, name, p_value
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.controls import ControlRow, RoundingRow, TrendRow
from avsec_gym.experiments.chapter5.decoupling import AttackRow
from avsec_gym.experiments.chapter5.flips import Flip
from avsec_gym.experiments.chapter5.patch_effects import PatchEffectRow
from avsec_gym.experiments.chapter5.section.condition_cells import condition_names, count_cell
from avsec_gym.experiments.chapter5.section.estimate_cell import estimate_cell
from avsec_gym.experiments.chapter5.seen import SeenRow
from avsec_gym.experiments.chapter5.settings import PERTURBATIONS, TEXTURE_ATTACKED, UNATTACKED
from avsec_gym.experiments.chapter5.tables import SafetyRow

_POINTS = "In percentage points; in brackets: 95 % bootstrap intervals over scenarios."


def loss_table(rows: Sequence[AttackRow]) -> Table:
    """What every attack takes, and which episodes it turns."""
    lines = [
        [
            *condition_names(row.condition),
            estimate_cell(row.precision_lost),
            estimate_cell(row.safety_lost),
            count_cell(row.paired.became_unsafe if row.paired else None),
            count_cell(row.paired.became_safe if row.paired else None),
            count_cell(row.paired.episodes if row.paired else None),
        ]
        for row in rows
    ]
    return Table(
        "What each attack takes",
        ["detector", "attack", "AP taken", "safe driving taken", "became unsafe", "became safe",
         "episodes"],
        lines,
        "AP: cars in 3D, IoU 0.7, moderate, 11 recall points. Safe driving: the three intentions"
        f" together. {_POINTS}",
        names=2, sortable=True, filters=(0,),
    )  # fmt: skip


def paired_table(rows: Sequence[SafetyRow]) -> Table:
    """Safe driving under each attack against unattacked, scenario by scenario."""
    lines = [
        [
            *condition_names(row.condition),
            name(row.intention),
            estimate_cell(row.paired.safe_driving_rate, scale=100, signed=True),
            count_cell(row.paired.became_unsafe),
            count_cell(row.paired.became_safe),
            TableCell(p_value(row.paired.mcnemar_p), key=row.paired.mcnemar_p),
            TableCell(p_value(row.mcnemar_p_holm), key=row.mcnemar_p_holm),
        ]
        for row in rows
        if row.paired is not None and row.condition.attack != UNATTACKED
    ]
    return Table(
        "Paired tests: the same scenarios, unattacked and attacked",
        ["detector", "attack", "intention", "safe driving, change", "became unsafe", "became safe",
         "p", "p, corrected"],
        lines,
        "p: McNemar’s exact test, two-sided; corrected: by Holm’s method for the number of rows."
        " Change in percentage points; in brackets: 95 % bootstrap intervals over scenarios, not"
        " corrected.",
        names=3, sortable=True, filters=(0, 2), folded=True,
    )  # fmt: skip


def seen_table(rows: Sequence[SeenRow]) -> Table:
    """Why: cars that are still found, ghosts in the driven lanes and beside them."""
    lines = [
        [
            *condition_names(row.condition),
            estimate_cell(row.cars_found, scale=100),
            estimate_cell(row.ghosts_in_lanes, digits=2),
            estimate_cell(row.ghosts_beside, digits=2),
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


def patch_effect_table(rows: Sequence[PatchEffectRow]) -> Table:
    """Why: how often the ghost of a patch is seen, and what it does then."""
    lines = [
        [
            *condition_names(row.condition),
            count_cell(row.episodes),
            *(
                estimate_cell(share, scale=100)
                for share in (row.seen, row.unsafe_seen, row.unsafe_unseen)
            ),
        ]
        for row in rows
    ]
    return Table(
        "Why: ghosts of patches, and what they do",
        ["detector", "attack", "episodes", "ghost seen, %", "unsafe if seen, %",
         "unsafe if not seen, %"],
        lines,
        "Of the episodes that are safe unattacked. A ghost is seen where the planner gets a box"
        " that meets it on the ground, as a real object there may: the grey disc shows how often."
        " In brackets: 95 % intervals by bootstrap over scenarios, whose episodes belong together;"
        " Wilson’s where no episode counts or all do.",
        names=2,
    )  # fmt: skip


def control_table(rows: Sequence[ControlRow]) -> Table:
    """The sanity sheet."""
    aims = {"up": "raises", "down": "lowers", None: "control"}
    towards = {"ghosts": "to its ghosts", "truth": "to the truth"}
    lines = []
    for row in rows:
        budget = UNKNOWN if row.budget is None else f"{row.budget:g}"
        aim = "not measured"
        if row.loss_towards is not None:
            aim = f"{towards[row.loss_towards]}, {aims[row.aim]}"
        lines.append(
            [
                *condition_names(row.condition),
                name(aim),
                figure(row.loss_before, digits=3),
                figure(row.loss_after, digits=3),
                estimate_cell(row.share_moved, scale=100),
                estimate_cell(row.ghosts_seen, scale=100),
                figure(row.largest_change, digits=2),
                TableCell(budget, tone="" if row.within_budget else "bad",
                     hint="" if row.within_budget else "exceeded"),
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
        " ground, as a real object at the same place may. In brackets: 95 % intervals, Wilson’s,"
        " of a specific attack widened by what looks at one scene share.",
        names=2,
    )  # fmt: skip


def trend_table(rows: Sequence[TrendRow]) -> Table:
    """Slopes over n."""
    lines = [
        [
            name(detector_name(row.detector)),
            name(attack_name(row.attack)),
            estimate_cell(row.precision_slope, signed=True),
            estimate_cell(row.safety_slope, signed=True),
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


def rounding_table(rows: Sequence[RoundingRow]) -> Table:
    """8 bits against float."""
    lines = [
        [
            *condition_names(row.condition),
            figure(row.precision_float),
            figure(row.precision_8_bit),
            estimate_cell(row.precision_difference, signed=True),
            figure(row.safety_float),
            figure(row.safety_8_bit),
            estimate_cell(row.safety_difference, signed=True),
        ]
        for row in rows
    ]
    return Table(
        "Whole grey levels: 8 bits against float",
        ["detector", "attack", *("float", "8 bits", "difference") * 2],
        lines,
        "Attacked pixels rounded once, at the end, as a camera’s bus would carry them. One step of"
        f" 0.4 grey levels vanishes. {_POINTS}",
        [("", 2), ("average precision, %", 3), ("safe driving, %", 3)],
        names=2,
    )


def flip_table(rows: Sequence[Flip]) -> Table:
    """Episodes that were safe and are not: one row for all strengths of an attack."""
    episodes: dict[tuple[str, ...], list[Flip]] = {}
    for flip in rows:
        if not flip.condition.whole_levels:
            place = (flip.condition.detector, flip.condition.attack, flip.scenario, flip.intention)
            episodes.setdefault(place, []).append(flip)
    lines, tones = [], {"collision": "bad", "unplanned": "warn"}
    for (detector, attack, scenario, intention), found in episodes.items():
        strengths = [flip.condition.strength for flip in found if flip.condition.strength]
        steps = ", ".join(f"{strength:g}" for strength in strengths)
        last = found[-1]
        lines.append(
            [
                name(detector_name(detector)),
                name(attack_name(attack)),
                name(scenario),
                name(intention),
                name(steps if attack in (*PERTURBATIONS, TEXTURE_ATTACKED) else ""),
                TableCell(last.outcome, tone=tones[last.outcome], words=True),
                name(last.why),
            ]
        )
    return Table(
        "Flips: safe unattacked, unsafe under attack",
        ["detector", "attack", "scene", "intention", "n", "became", "why"],
        lines,
        "At the largest n where there are several. Attacks in 8 bits are in the JSON only.",
        names=7, sortable=True, filters=(0, 1, 3, 5),
    )  # fmt: skip
