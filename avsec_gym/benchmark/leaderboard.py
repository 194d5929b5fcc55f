"""Entries of one version side by side: a table for each kind."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from avsec_gym.benchmark.entry import Entry, EntryRow
from avsec_gym.benchmark.leaderboard_cells import (
    box_cell,
    broken_cell,
    entry_cell,
    estimate_cell,
    share_cell,
)
from avsec_gym.benchmark.leaderboard_connected import connected_table
from avsec_gym.benchmark.leaderboard_drives import closed_loop_table
from avsec_gym.benchmark.leaderboard_kitti import has_kitti, kitti_table
from avsec_gym.benchmark.protocol import (
    ADAPTIVE,
    DETECTORS,
    OPTICAL,
    PATCH,
    STRONGER,
    TRANSFERRED,
    TRUTH,
    UNATTACKED,
    VALIDATED,
    WHITE_BOX,
    Entered,
    adaptive,
)
from avsec_gym.benchmark.scene_sets import ALL, CONTESTED, VERSION
from avsec_gym.drawing.page_table import UNKNOWN, Table, TableCell, figure, name
from avsec_gym.emergency_stop import STOPPED
from avsec_gym.runs.section import Section

_SAFE = "Safe driving rates in percent, on contested scenes; in brackets 95 % intervals."


def board(entries: Iterable[Entry]) -> list[Section]:
    """A section for each kind of entry, best first.

    Args:
        entries: Entries of this version, none of them quick.
    """
    makers = {
        Entered.DETECTOR: _detectors,
        Entered.ATTACK: _attacks,
        Entered.VALIDATOR: _validators,
        Entered.PLANNER: _planners,
    }
    by_kind: dict[Entered, list[Entry]] = {}
    for entry in entries:
        by_kind.setdefault(entry.kind, []).append(entry)
    sections = []
    for kind, make in makers.items():
        if own := by_kind.get(kind):
            title = f"{str(kind).capitalize()}s"
            tables = []
            if queried := [entry for entry in own if _is_queried(entry)]:
                tables.append(make(queried))
            if real := [entry for entry in own if has_kitti(entry)]:
                tables.append(kitti_table(real))
            if driven := [entry for entry in own if entry.drives]:
                tables.append(closed_loop_table(kind, driven))
            if connected := [entry for entry in own if entry.instants]:
                tables.append(connected_table(connected))
            sections.append(Section(f"{kind}s", title, parts=tables))
    return sections


def _is_queried(entry: Entry) -> bool:
    """Whether it was driven in single queries of the benchmark's own scenes."""
    return any(row.scenes in (ALL, CONTESTED) for row in entry.rows)


def left_out(entry: Entry) -> str:
    """Why an entry is on no leaderboard of this version; empty: it is on it."""
    if entry.version != VERSION:
        return f"is of version {entry.version} of the benchmark; this is version {VERSION}"
    if entry.quick:
        return "is a quick entry: make it without --quick"
    if entry.failed:
        return f"lacks {entry.failed} scenes, which failed"
    return ""


def _detectors(entries: Sequence[Entry]) -> Table:
    settings = (UNATTACKED, TRANSFERRED, WHITE_BOX, PATCH)
    on_contested = (*settings, ADAPTIVE)
    titles = {WHITE_BOX: "own gradients", TRANSFERRED: "other's gradients"}
    columns = ["detector", "known to the attacker", "adaptive attack breaks it"]
    columns += ["hides its gradients"]
    columns += ["safe, worst case"]
    columns += [f"safe, {titles.get(setting, setting)}" for setting in on_contested]
    columns += [f"AP, {titles.get(setting, setting)}" for setting in settings]
    rows = [
        [
            entry_cell(entry),
            box_cell(bool(entry.white_box)),
            broken_cell(entry),
            _masked(entry),
            _safe(_worst(entry)),
            *(_safe(entry.row(CONTESTED, setting)) for setting in on_contested),
            *(_precision(entry.row(ALL, setting)) for setting in settings),
        ]
        for entry in _safest_first(entries, CONTESTED, UNATTACKED)
    ]
    note = (
        f"{_SAFE} AP: average precision of moderate cars in 3D at an overlap of 0.7, 11 recall "
        "points, on all scenes. Attacks: projected gradient descent, 4 grey levels, 7 steps; a "
        "patch that was trained against earlier weights of both of the package's detectors, which "
        "its card names, and is kept so that the attack stays the same. Hides its gradients: "
        "another detector's gradients leave fewer episodes safe than its own in the same budget, "
        "the whole interval of the paired difference below 0. Adaptive: the attacker takes "
        f"{STRONGER['steps']} steps, begins anew, takes the gradients of other detectors and of "
        "the network behind a defence, and keeps what harms this detector most, on contested "
        "scenes; the entry is broken where that leaves fewer episodes safe than each listed attack "
        "of the same budget, the whole intervals below 0. The patch has another budget, any grey "
        "level in a disc, and is left out of both comparisons. Worst case: the setting with the "
        "fewest safe episodes."
    )
    return Table(
        "Detectors, the safest to drive by first",
        columns,
        rows,
        note,
        names=4,
        sortable=True,
        filters=(1, 2, 3),
    )


def _attacks(entries: Sequence[Entry]) -> Table:
    columns = ["attack", "known to the attacker", "change, grey levels", "pixels"]
    columns += [f"safe under it, {detector}" for detector in DETECTORS]
    columns += [f"change of safe, {detector}" for detector in DETECTORS]
    columns += [f"AP under it, {detector}" for detector in DETECTORS]
    rows = []
    for entry in sorted(entries, key=_left_safe):
        found = [entry.row(CONTESTED, f"{detector} attacked") for detector in DETECTORS]
        seen = [entry.row(ALL, f"{detector} attacked") for detector in DETECTORS]
        budget = entry.budget or {}
        rows.append(
            [
                entry_cell(entry),
                box_cell(entry.white_box),
                figure(budget.get("change")),
                name("all") if budget and budget["area"] is None else figure(budget.get("area")),
                *map(_safe, found),
                *map(_difference, found),
                *map(_precision, seen),
            ]
        )
    note = (
        f"{_SAFE} Changes are against the same drives without the attack, in points. "
        "Compare attacks of one budget: the most that any channel of a pixel may change. White "
        "box: it takes the gradients of the detector that it meets. An attack defends nothing, so "
        "there is nothing that an adaptive attack could break."
    )
    title = f"Attacks, the most harmful to {DETECTORS[0]} first"
    return Table(title, columns, rows, note, names=2, sortable=True, filters=(1,))


def _validators(entries: Sequence[Entry]) -> Table:
    columns = ["validator", "adaptive attack breaks it", "false alarms, %"]
    columns += [f"alarms, {case}, %" for case in OPTICAL]
    columns += [f"named, {case}, %" for case in OPTICAL]
    columns += ["needless stops, %"]
    for case in OPTICAL:
        columns += [f"collisions, {case}, %", f"without it, {case}, %"]
    for case in OPTICAL:
        columns += [f"alarms, {case}, adaptive, %", f"collisions, {case}, adaptive, %"]
    rows = []
    for entry in sorted(entries, key=_cost):
        clean = entry.row(ALL, UNATTACKED + VALIDATED)
        seen = [entry.row(ALL, case + VALIDATED) for case in OPTICAL]
        cells = [entry_cell(entry), broken_cell(entry)]
        cells += [share_cell(row.alarms if row else None) for row in (clean, *seen)]
        cells += [share_cell(row.named if row else None) for row in seen]
        cells.append(share_cell(clean.stopped if clean else None))
        for case in OPTICAL:
            for setting in (case + VALIDATED, case):
                row = entry.row(CONTESTED, setting)
                cells.append(share_cell(row.collided if row else None))
        for case in OPTICAL:
            row = entry.row(CONTESTED, adaptive(case))
            cells += [
                share_cell(share) for share in ((row.alarms, row.collided) if row else (None, None))
            ]
        rows.append(cells)
    note = (
        "Alarms, named sensors and needless stops on all scenes: at an alarm the car stops. "
        "Collisions of all contested drives under each attack, and of the same drives without a "
        "validator. Adaptive: the attacker asks car and validator as black boxes, tries light that "
        "is weaker or smaller, and keeps what makes most contested drives collide without an "
        "alarm; the validator is broken where the whole interval of the paired difference of "
        "collisions is above 0. In brackets 95 % intervals."
    )
    title = "Validators, by collisions under attack and needless stops together, the fewest first"
    return Table(title, columns, rows, note, names=2, sortable=True, filters=(1,))


def _cost(entry: Entry) -> tuple[float, str]:
    """Shares of drives that collide under attack, and that stop without one; missing ones last."""
    driven = [entry.row(CONTESTED, case + VALIDATED) for case in OPTICAL]
    clean = entry.row(ALL, UNATTACKED + VALIDATED)
    if clean is None or None in driven:
        return math.inf, entry.name
    collisions = [row.rates.collisions / row.rates.scenarios for row in driven if row]
    needless = clean.rates.failures.get(STOPPED, 0) / clean.rates.scenarios
    return sum(collisions) / len(collisions) + needless, entry.name


def _left_safe(entry: Entry) -> tuple[float, str]:
    row = entry.row(CONTESTED, f"{DETECTORS[0]} attacked")
    return (math.inf if row is None else row.rates.safe_driving_rate), entry.name


def _planners(entries: Sequence[Entry]) -> Table:
    columns = ["planner", "safe, all, %", "safe, contested, %", "collisions, all, %"]
    columns += ["travel time, s", "cost SM1"]
    rows = []
    for entry in _safest_first(entries, ALL, TRUTH):
        every, contested = entry.row(ALL, TRUTH), entry.row(CONTESTED, TRUTH)
        rates = every.rates if every is not None else None
        found = rates.to_json() if rates is not None else {}
        rows.append(
            [
                entry_cell(entry),
                _safe(every),
                _safe(contested),
                figure(
                    found.get("collision_rate"), found.get("collision_rate_interval"), scale=100
                ),
                figure(found.get("mean_travel_time"), digits=2),
                figure(found.get("mean_sm1_cost"), digits=1),
            ]
        )
    return Table(
        "Planners, the safest first",
        columns,
        rows,
        "Planners know the truth. Contested scenes are some that A* drives safely. Travel time and "
        "cost are means over each planner's own drives. No attack knows a planner: what it is "
        "misled by is a detector's error, in closed loop below.",
        sortable=True,
    )


def _safest_first(entries: Sequence[Entry], scenes: str, setting: str) -> list[Entry]:
    def rate(entry: Entry) -> float:
        row = entry.row(scenes, setting)
        return -1.0 if row is None else row.rates.safe_driving_rate

    return sorted(entries, key=lambda entry: (-rate(entry), entry.name))


def _masked(entry: Entry) -> TableCell:
    if entry.masked:
        return TableCell("yes", tone="bad", words=True)
    return name("no" if entry.white_box else UNKNOWN)


def _worst(entry: Entry) -> EntryRow | None:
    rows = [row for row in entry.rows if row.scenes == CONTESTED]
    return min(rows, key=lambda row: row.rates.safe_driving_rate, default=None)


def _safe(row: EntryRow | None) -> TableCell:
    if row is None:
        return figure(None)
    rates = row.rates.to_json()
    return figure(
        rates["safe_driving_rate"],
        rates["safe_driving_rate_interval"],
        scale=100,
        hint=f"{row.rates.scenarios} drives",
    )


def _difference(row: EntryRow | None) -> TableCell:
    if row is None or row.paired is None:
        return figure(None)
    return estimate_cell(row.paired.safe_driving_rate, scale=100, signed=True)


def _precision(row: EntryRow | None) -> TableCell:
    if row is None or row.precision is None:
        return figure(None)
    return estimate_cell(row.precision.strict)
