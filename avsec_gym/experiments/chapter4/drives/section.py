"""What a run shows of the test over frames."""

from __future__ import annotations

from avsec_gym.drawing.page_table import Table, TableCell, figure, name
from avsec_gym.experiments.chapter4.drives.settings import WINDOW
from avsec_gym.experiments.chapter4.drives.window_rates import (
    DESIGNATED_DETECTION,
    DrivesSummary,
    drives_summary,
)
from avsec_gym.experiments.chapter4.settings import USUAL
from avsec_gym.experiments.chapter4.shown_figures import IN_WORDS
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``connected_drives``.

    Args:
        run: The run.
        request: What the report is asked for; nothing here depends on it.
    """
    summary = drives_summary(run)
    sections = [drives_section(summary)] if summary else []
    return Findings(sections, {"connected_drives": as_json(summary)})


def drives_section(summary: DrivesSummary) -> Section:
    """The section of a summary.

    Args:
        summary: The results of a run.
    """
    return Section(
        "connected_drives",
        "What adds up over a second of successive instants?",
        [],
        [drives_table(summary)],
        link="Connected vehicles, over a second",
        context=f"{summary.judged} attack-free windows and {summary.attacked} under a ghost that"
        f" drives ahead of its victim; limits of {summary.fitted} windows of other drives and"
        f" assets. {USUAL.name}.",
    )


def drives_table(summary: DrivesSummary) -> Table:
    """False alarms and detection, by method and designated rate.

    Args:
        summary: The results of a run.
    """
    return Table(
        f"Windows of {WINDOW} instants, by the cumulative sum of their highest scores",
        [
            *(
                "method",
                "r of windows",
                "limit",
                "false alarms, %",
                "drives that alarm, at most, %",
            ),
            *("detected, %", "of decidable, %", "by one instant alone, %"),
        ],
        [
            [
                name(IN_WORDS[row.method]),
                name(_WHERE if row.rate is None else f"{100 * row.rate:g} %"),
                figure(row.limit, digits=1),
                _percent(row.false_alarms),
                figure(row.drives, scale=100),
                _percent(row.detected),
                _percent(row.of_decidable),
                _percent(row.by_highest),
            ]
            for row in summary.rates
        ],
        "Limits are those that a share r of attack-free windows of other drives exceeds, or, as"
        f" stated, that at which {100 * DESIGNATED_DETECTION:g} % of the judged decidable attacks"
        " are detected. In brackets: 95 % intervals, which know that windows of one drive are"
        " alike. At most: an upper bound with 95 % confidence, where a drive counts once. By one"
        " instant alone: the highest score of a window, at a threshold of the same r.",
        names=2,
    )


_WHERE = f"detection {100 * DESIGNATED_DETECTION:g} %"


def _percent(share: Share) -> TableCell:
    return figure(share.rate, share.interval, scale=100)
