"""The leaderboard's tables of the closed loop."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence

from avsec_gym.benchmark.entry import Entry
from avsec_gym.benchmark.leaderboard_cells import box_cell, entry_cell, estimate_cell, share_cell
from avsec_gym.benchmark.loop_drives import DrivesRow
from avsec_gym.benchmark.protocol import Entered
from avsec_gym.drawing.page_table import Table, TableCell, name

_NOTE = (
    "On drives in which a car that sees nothing collides by its own fault or leaves the road, and "
    "one that knows the truth and plans by A* reaches its goal; no image is rendered, a detector "
    "stands in them by its error model. At fault: collisions that the car is to blame for, by "
    "nuPlan's rule. Progress: share of the way at the least cruising speed. Score: NAVSIM's, in "
    "percent. In brackets 95 % intervals, which know which drives share a scene."
)


def closed_loop_table(kind: Entered, entries: Sequence[Entry]) -> Table:
    """A row for each setting of each entry, entries with the best score first.

    Args:
        kind: What the entries are.
        entries: Entries that were driven in closed loop.
    """
    columns = [str(kind), "car", "known to the attacker"]
    columns += ["at fault, %", "collisions, %", "off the road, %", "goal, %"]
    columns += ["progress, %", "score, %", "change of score"]
    rows = [
        _cells(entry, row) for entry in sorted(entries, key=_best_first) for row in entry.drives
    ]
    return Table(
        "In closed loop, by the score of the first car, the best first",
        columns,
        rows,
        _NOTE,
        names=3,
        sortable=True,
        filters=(1,) if kind == Entered.PLANNER else (1, 2),
    )


def _best_first(entry: Entry) -> tuple[float, str]:
    score = entry.drives[0].navsim_score.value
    return (math.inf if score is None else -score), entry.name


def _cells(entry: Entry, row: DrivesRow) -> list[TableCell]:
    attack = json.dumps(row.attack) if isinstance(row.attack, dict) else str(row.attack)
    return [
        entry_cell(entry),
        name(row.setting, hint=f"attack {attack}" if attack else ""),
        box_cell(row.white_box),
        *map(share_cell, (row.at_fault, row.collision, row.off_road, row.goal)),
        estimate_cell(row.progress, scale=100),
        estimate_cell(row.navsim_score, scale=100),
        estimate_cell(row.navsim_difference, scale=100, signed=True),
    ]
