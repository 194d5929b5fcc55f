"""The leaderboard's table of validators of several vehicles."""

from __future__ import annotations

import math
from collections.abc import Sequence

from avsec_gym.benchmark.connected_instants import ATTACKS, FALSE_ALARMS, adaptive_instants
from avsec_gym.benchmark.entry import Entry
from avsec_gym.benchmark.leaderboard_cells import (
    broken_cell,
    entry_cell,
    estimate_cell,
    share_cell,
)
from avsec_gym.benchmark.protocol import UNATTACKED
from avsec_gym.benchmark.quiet_attacks import INSTANT_TRIES
from avsec_gym.drawing.page_table import Table, TableCell

_RATE = f"{100 * FALSE_ALARMS:.0f} %"
_NOTE = (
    "Three vehicles, with errors of poses and clocks; in one scan a ghost, or an object removed. "
    "False alarms: attack-free instants with an alarm; honest named: those at which a vehicle is "
    "named. Detected: of the attacks of which another vehicle has rays enough to tell, those about "
    f"which the validator alarms by its own threshold. At {_RATE}: those above the score that "
    f"{_RATE} of the attack-free instants exceed. AUC: area under the ROC curve of the same. "
    "Victim, another, cannot tell: what is named, of all attacks. Adaptive: the attacker tries "
    f"{INSTANT_TRIES} attacks of that kind and keeps the one that the validator, which he asks as "
    "a black box, is least sure of, among those of which another vehicle can tell; the validator "
    "is broken where the whole interval of the paired difference of detections is below 0. In "
    "brackets 95 % intervals."
)


def connected_table(entries: Sequence[Entry]) -> Table:
    """A row for each entry, the largest areas under the ROC curve first.

    Args:
        entries: Entries of validators of several vehicles.
    """
    columns = ["validator", "adaptive attack breaks it", "false alarms, %", "honest named, %"]
    for kind in ATTACKS:
        own = ["AUC, %", f"at {_RATE}, %", "detected, %"]
        own += ["victim, %", "another, %", "cannot tell, %"]
        columns += [f"{kind}: {each}" for each in own]
    columns += [f"{kind}, adaptive: detected, %" for kind in ATTACKS]
    return Table(
        "Connected vehicles, by the mean area under the ROC curve, the largest first",
        columns,
        [_cells(entry) for entry in sorted(entries, key=_largest_first)],
        _NOTE,
        names=2,
        sortable=True,
        filters=(1,),
    )


def _largest_first(entry: Entry) -> tuple[float, str]:
    rows = [entry.instant(kind) for kind in ATTACKS]
    areas = [row.area.value for row in rows if row and row.area and row.area.value is not None]
    return (-sum(areas) / len(areas) if areas else math.inf), entry.name


def _cells(entry: Entry) -> list[TableCell]:
    clean = entry.instant(UNATTACKED)
    cells = [entry_cell(entry), broken_cell(entry)]
    cells += [
        share_cell(clean.alarms if clean else None),
        share_cell(clean.honest_named if clean else None),
    ]
    for kind in ATTACKS:
        row = entry.instant(kind)
        cells.append(estimate_cell(row.area if row else None, scale=100))
        for name in ("at_rate", "of_decidable", "victim", "another", "cannot_tell"):
            cells.append(share_cell(getattr(row, name) if row else None))
    for kind in ATTACKS:
        row = entry.instant(adaptive_instants(kind))
        cells.append(share_cell(row.of_decidable if row else None))
    return cells
