"""What a run shows of detectors under optical attacks, and of attacks that objects reveal."""

from __future__ import annotations

from avsec_gym.experiments.chapter3.objects.baseline_rates import baseline_summary
from avsec_gym.experiments.chapter3.objects.believed_rates import believed_summary
from avsec_gym.experiments.chapter3.objects.impact_rates import impact_summary
from avsec_gym.experiments.chapter3.objects.in_words import optical_sentences
from avsec_gym.experiments.chapter3.objects.plots import figure_of_sensitivity
from avsec_gym.experiments.chapter3.objects.sensitivity_curves import sensitivity_summary
from avsec_gym.experiments.chapter3.objects.tables import (
    OpticalSummaries,
    tables_of_optical_attacks,
)
from avsec_gym.experiments.chapter3.recordings import assets_in_words
from avsec_gym.experiments.json_rows import row_json
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``baseline``, ``impact``, ``believed`` and ``sensitivity``.

    Raises:
        DataError: The recordings are not where they were.
    """
    summaries = OpticalSummaries(
        baseline_summary(run, run.configuration),
        impact_summary(run, run.configuration),
        believed_summary(run, run.configuration),
        sensitivity_summary(run, run.configuration),
    )
    sections = [] if summaries == OpticalSummaries() else [optical_section(summaries)]
    remarks = assets_in_words(run.configuration) if sections else []
    return Findings(sections, row_json(summaries), remarks=remarks)


def optical_section(summaries: OpticalSummaries) -> Section:
    """The section of the summaries that a run has.

    Args:
        summaries: The results of a run.
    """
    sizes = summaries.sensitivity
    return Section(
        "optical",
        "What optical attacks do to detectors",
        optical_sentences(summaries),
        [
            *([figure_of_sensitivity(sizes)] if sizes else []),
            *tables_of_optical_attacks(summaries),
        ],
        link="Detectors under optical attacks",
    )
