"""What a run shows of attacks that sensors detect and name."""

from __future__ import annotations

from avsec_gym.experiments.chapter3.identification.in_words import validation_sentences
from avsec_gym.experiments.chapter3.identification.plots import figures_of_validation
from avsec_gym.experiments.chapter3.identification.summary import (
    ValidationSummary,
    validation_summary,
)
from avsec_gym.experiments.chapter3.identification.tables import tables_of_validation
from avsec_gym.experiments.chapter3.recordings import JUDGED, assets_in_words
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``validation``.

    Raises:
        DataError: The recordings are not where they were.
    """
    summary = validation_summary(run, run.configuration, request.looked_at)
    return Findings(
        [validation_section(summary)] if summary else [],
        {"validation": as_json(summary)},
        remarks=assets_in_words(run.configuration) if summary else [],
    )


def validation_section(summary: ValidationSummary) -> Section:
    """The section of a summary.

    Args:
        summary: The results of a run.
    """
    return Section(
        "validation",
        "Is an attack detected, and the attacked sensor named?",
        validation_sentences(summary),
        [*tables_of_validation(summary), *figures_of_validation(summary)],
        link="Sensor data validation",
        context=f"{summary.frames[JUDGED]} frames of {summary.drives[JUDGED]} drives,"
        f" on none of which anything was fitted; depth by {summary.depth['name']}. S0 is the"
        " LiDAR, S1 to S3 are the cameras from right to left.",
    )
