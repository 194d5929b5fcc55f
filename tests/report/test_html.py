"""The page of a run: what its footer claims of the thesis' figures."""

from __future__ import annotations

import json
from pathlib import Path

from markupsafe import Markup

from avsec_gym.drawing.page_table import Table, figure, name
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.report.html import html_page
from avsec_gym.report.run_facts import RunFacts
from avsec_gym.report.run_report import RunReport
from avsec_gym.runs.section import Findings, Section

RESULTS = Path(__file__).parents[2] / "studies" / "results"


def test_the_thesis_figures_are_said_to_be_in_italics_only_where_there_are_some() -> None:
    facts = row_of(RunFacts, json.loads((RESULTS / "five_sensors.json").read_text()))

    def page(thesis: float | None, *, folded: bool = False) -> str:
        rows = [[name("DSGN"), figure(1.0, thesis=thesis)]]
        table = Table("Precision", ["detector", "AP"], rows, folded=folded)
        section = Section("own", "Own", parts=[Markup("<p>words</p>"), table])
        return html_page(RunReport(facts, [Findings([section])]))

    words = "its figures are in italics"
    assert words not in page(None)
    assert words in page(2.0)
    assert words in page(2.0, folded=True)
