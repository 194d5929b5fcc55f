"""What a run shows of a car's own evidence joined with that of connected vehicles."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import Table, figure, name, number
from avsec_gym.experiments.chapter4.joined.rates import JoinedRow, joined_rows
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``joined_identification``.

    Args:
        run: The run.
        request: What the report is asked for; nothing here depends on it.
    """
    rows = joined_rows(run)
    sections = [joined_section(rows)] if rows else []
    return Findings(sections, {"joined_identification": as_json(rows)})


def joined_section(rows: Sequence[JoinedRow]) -> Section:
    """The section of a run.

    Args:
        rows: The rows of the run, one or more.
    """
    return Section(
        "joined_identification",
        "Do connected vehicles name more attacked sensors of a car than it can itself?",
        [
            f"With {row.attacked} attacked, the car alone names exactly that in"
            f" {number(row.alone.rate, scale=100)} % of {row.alone.of} frames, and with what"
            f" connected vehicles report in {number(row.joined.rate, scale=100)} %."
            for row in rows
        ],
        [_table(rows)],
        link="Joined identification",
        context="A LiDAR and two cameras of one of five connected vehicles. Of three sensors the"
        " thesis’ algorithms name none; alone means by likelihood, which often does. What a report"
        " of the others is worth is counted over all other places of the run.",
    )


def _table(rows: Sequence[JoinedRow]) -> Table:
    return Table(
        "Attacked sensors named exactly",
        ["attacked", "frames", "alone, %", "joined, %", "LiDAR named by others, %"],
        [
            [
                name(row.attacked),
                figure(row.alone.of, digits=0),
                *(
                    figure(share.rate, share.interval, scale=100)
                    for share in (row.alone, row.joined, row.lidar_named)
                ),
            ]
            for row in rows
        ],
        "Named: with a probability of 0.95 or more, after an alarm; without an attack, no sensor"
        " may be. In brackets: 95 % intervals (Wilson).",
    )
