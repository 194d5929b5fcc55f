"""What a run shows over the parameters that the thesis leaves open."""

from __future__ import annotations

from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter3.diagrams.in_words import diagram_sentences
from avsec_gym.experiments.chapter3.diagrams.plots import figures_of_diagrams
from avsec_gym.experiments.chapter3.diagrams.summary import DiagramsSummary, diagrams_summary
from avsec_gym.experiments.chapter3.diagrams.tables import tables_of_diagrams
from avsec_gym.experiments.chapter3.diagrams.variant import SATURATED
from avsec_gym.experiments.chapter3.recordings import assets_in_words
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``diagrams``.

    Raises:
        DataError: The recordings are not where they were.
    """
    summary = diagrams_summary(run, run.configuration)
    return Findings(
        [diagrams_section(summary)] if summary else [],
        {"diagrams": as_json(summary)},
        remarks=assets_in_words(run.configuration) if summary else [],
    )


def diagrams_section(summary: DiagramsSummary) -> Section:
    """The section of a summary.

    Args:
        summary: The results of a run.
    """
    return Section(
        "diagrams",
        "How do chapter 3’s figures depend on what the thesis leaves open?",
        diagram_sentences(summary),
        [*figures_of_diagrams(summary), *tables_of_diagrams(summary)],
        link="Density, depth, strength and matcher",
        context="Bogus objects stand where the thesis’ planes stand, 6 to 10 m ahead; lights"
        " anywhere in the image of S2 or S3, in turn. Of one frame all of them stand at one place."
        f" A flat-topped light is white within {number(SATURATED, 100, 0)} % of its radius, however"
        " strong it is beyond.",
    )
