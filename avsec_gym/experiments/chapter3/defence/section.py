"""What a run shows of a validator before the detector."""

from __future__ import annotations

from avsec_gym.experiments.chapter3.defence.in_words import defence_sentences
from avsec_gym.experiments.chapter3.defence.plots import figure_of_defence
from avsec_gym.experiments.chapter3.defence.rates import (
    DefenceSummary,
    defence_summary,
    is_of_defence,
)
from avsec_gym.experiments.chapter3.defence.tables import tables_of_defence
from avsec_gym.experiments.chapter3.recordings import assets_in_words
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``defence``."""
    summary = defence_summary(run)
    settings = {setting for setting, _ in run.settings() if is_of_defence(setting)}
    sections = [defence_section(summary)] if summary else []
    remarks = assets_in_words(run.configuration) if summary else []
    return Findings(sections, {"defence": as_json(summary)}, settings, remarks=remarks)


def defence_section(summary: DefenceSummary) -> Section:
    """The section of a summary.

    Args:
        summary: The rows of a run.
    """
    return Section(
        "defence",
        "What is a validator before the detector worth?",
        defence_sentences(summary),
        [figure_of_defence(summary.worth), *tables_of_defence(summary)],
        link="What a defence is worth",
    )
