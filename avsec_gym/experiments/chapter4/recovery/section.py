"""What a run shows of recovered scans."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import Table, bounds, figure, name, number
from avsec_gym.experiments.chapter4.recovery.cells import KNOWN, Case
from avsec_gym.experiments.chapter4.recovery.rates import (
    RecoveryRow,
    is_of_recovery,
    recovery_rows,
)
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section

_IN_WORDS: dict[Case, str] = {
    "clean": "Without an attack",
    "ghost": "With a ghost ahead",
    "removal": "With an object removed",
}


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``connected_recovery``.

    Args:
        run: The run.
        request: What the report is asked for; nothing here depends on it.
    """
    rows = recovery_rows(run)
    own = {setting for setting, _ in run.settings() if is_of_recovery(setting)}
    sections = [recovery_section(rows)] if rows else []
    return Findings(sections, {"connected_recovery": as_json(rows)}, {*own, KNOWN} if own else own)


def recovery_section(rows: Sequence[RecoveryRow]) -> Section:
    """The section of a run.

    Args:
        rows: The rows of the run, one or more.
    """
    return Section(
        "connected_recovery",
        "What do recovered scans save: collisions, and needless stops?",
        [_sentence(alone, joined) for alone, joined in zip(rows[::2], rows[1::2], strict=True)],
        [_table(rows)],
        link="Recovered scans",
        context="Five vehicles with the usual errors of poses and clocks; the first one drives, and"
        " its scan is attacked. Connected, it drives on the scan that the others give back where it"
        " is named, and stops where its LiDAR may be attacked and cannot be cleared.",
    )


def _sentence(alone: RecoveryRow, joined: RecoveryRow) -> str:
    return (
        f"{_IN_WORDS[alone.case]}, {_percent(alone.collisions)} of a lone car's episodes collide"
        f" and {_percent(joined.collisions)} of a connected one's, with {alone.detector};"
        f" {_percent(alone.needless_stops)} and {_percent(joined.needless_stops)} end in a needless"
        " stop."
    )


def _percent(share: Share) -> str:
    if share.rate is None or share.interval is None:
        return "none"
    return f"{number(share.rate, scale=100)} % {bounds(share.interval, scale=100)}"


def _table(rows: Sequence[RecoveryRow]) -> Table:
    return Table(
        "Driving on attacked and recovered scans",
        ["detector", "attack", "car", "episodes", "collisions, %", "needless stops, %", "safe, %"],
        [
            [
                *(name(row.detector), name(row.case), name(row.car)),
                figure(row.collisions.of, digits=0),
                *(
                    figure(share.rate, share.interval, scale=100)
                    for share in (row.collisions, row.needless_stops, row.safe)
                ),
            ]
            for row in rows
        ],
        "Three intentions at each place. Needless stops: episodes without a trajectory, of those"
        " for which the planner finds a safe one when it knows all that is there. In brackets: 95 %"
        " intervals, which know that episodes of one place are alike.",
        names=3,
    )
