"""What a run shows of detectors under optical attacks, and of attacks that objects reveal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.experiments.chapter3.objects.baseline_rates import baseline_summary
from avsec_gym.experiments.chapter3.objects.believed_rates import believed_summary
from avsec_gym.experiments.chapter3.objects.impact_rates import impact_summary
from avsec_gym.experiments.chapter3.objects.in_words import optical_sentences
from avsec_gym.experiments.chapter3.objects.plots import figure_of_sensitivity
from avsec_gym.experiments.chapter3.objects.sensitivity_curves import sensitivity_summary
from avsec_gym.experiments.chapter3.objects.tables import tables_of_optical_attacks
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section

_SUMMARIES = {
    "baseline": baseline_summary,
    "impact": impact_summary,
    "believed": believed_summary,
    "sensitivity": sensitivity_summary,
}


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``baseline``, ``impact``, ``believed`` and ``sensitivity``.

    Raises:
        DataError: The recordings are not where they were.
    """
    summaries = {name: of(run, run.configuration) for name, of in _SUMMARIES.items()}
    return Findings([optical_section(summaries)] if any(summaries.values()) else [], summaries)


def optical_section(summaries: Mapping[str, Any]) -> Section:
    """The section of the summaries that a run has.

    Args:
        summaries: See `avsec_gym.experiments.chapter3.objects.tables.tables_of_optical_attacks`.
    """
    sizes = summaries.get("sensitivity")
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
