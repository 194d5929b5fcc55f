"""What a run shows of connected vehicles."""

from __future__ import annotations

from avsec_gym.experiments.chapter4.in_words import connected_sentences
from avsec_gym.experiments.chapter4.plots import figures_of_connected
from avsec_gym.experiments.chapter4.settings import JUDGED
from avsec_gym.experiments.chapter4.summary import ConnectedSummary, connected_summary
from avsec_gym.experiments.chapter4.tables import tables_of_connected
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``connected``.

    Args:
        run: The run.
        request: What the report is asked for; nothing here depends on it.
    """
    summary = connected_summary(run)
    sections = [connected_section(summary)] if summary else []
    return Findings(sections, {"connected": as_json(summary)})


def connected_section(summary: ConnectedSummary) -> Section:
    """The section of a summary.

    Args:
        summary: The results of a run.
    """
    counts = [counts[JUDGED] for counts in summary.instants.values()]
    judged = f"{min(counts)} to {max(counts)}" if min(counts) < max(counts) else str(max(counts))
    return Section(
        "connected",
        "Do connected vehicles detect that one of them is lied to by its LiDAR?",
        connected_sentences(summary),
        [*figures_of_connected(summary), *tables_of_connected(summary)],
        link="Connected vehicles",
        context=f"{judged} judged instants of each condition, each at a place of its own; ghosts"
        " are pasted and objects removed once at each. Regions are those that the vehicles propose"
        " from their scans, not true boxes. Decidable is, where nothing else is written, what clean"
        " scans from true poses decide, for all methods alike.",
    )
