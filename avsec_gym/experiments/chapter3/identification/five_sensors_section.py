"""What a run shows of two attacked sensors of five."""

from __future__ import annotations

from avsec_gym.experiments.chapter3.identification.five_sensors import FiveSummary, five_summary
from avsec_gym.experiments.chapter3.identification.in_words import five_sentence
from avsec_gym.experiments.chapter3.identification.tables_of_five_sensors import table_of_five
from avsec_gym.experiments.chapter3.recordings import assets_in_words
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``five_sensors``.

    Raises:
        DataError: The recordings are not where they were.
    """
    summary = five_summary(run, run.configuration)
    return Findings(
        [five_section(summary)] if summary else [],
        {"five_sensors": as_json(summary)},
        remarks=assets_in_words(run.configuration) if summary else [],
    )


def five_section(summary: FiveSummary) -> Section:
    """The section of a summary.

    Args:
        summary: The results of a run.
    """
    return Section(
        "five",
        "Are two attacked ones of five sensors named?",
        [five_sentence(summary)],
        [table_of_five(summary)],
        link="Two of five sensors attacked",
    )
