"""A run's report as one HTML page that needs nothing else: styles, script, pictures inside."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from jinja2 import Environment
from markupsafe import Markup, escape

from avsec_gym.drawing.page_figure import Figure
from avsec_gym.drawing.page_table import Table, number
from avsec_gym.drawing.page_templates import page_templates
from avsec_gym.report.run_facts import CellTimes
from avsec_gym.report.run_remarks import facts, inputs, remarks
from avsec_gym.report.run_report import RunReport
from avsec_gym.report.run_tables import other_table, time_table
from avsec_gym.runs.section import Section, SectionPart


def html_page(report: RunReport) -> str:
    """The page.

    Args:
        report: Facts of the run and the sections of its experiments.
    """
    environment = page_environment()
    run, sections = report.facts, [*report.sections]
    if report.other:
        sections.append(Section("other", "Other settings", parts=[other_table(report.other)]))
    shown: dict[str, Any] = {
        "question": run.question,
        "run": run.manifest,
        "failures": run.failures,
        "extent": report.extent,
        "remarks": remarks(report),
        "answer": report.answer,
        "sections": sections,
        "links": [(section.id, section.link or section.title) for section in sections]
        + [("run", "The run")],
        "facts": facts(run),
        "inputs": inputs(run),
        "bars": _bars(run.timings.parts),
        "time": time_table(run.timings.attacks, report.attack_names),
        "css": joined(environment, "report.css", (found.style for found in report.findings)),
        "js": joined(environment, "report.js", (found.script for found in report.findings)),
    }
    return environment.get_template("report.html.j2").render(shown)


def page_environment() -> Environment:
    """What renders pages: `Section`s, tables and figures."""
    environment = page_templates("avsec_gym.report")
    environment.filters["kind"] = _kind
    environment.filters["heading"] = _heading
    return environment


def joined(environment: Environment, name: str, own: Iterable[str] = ()) -> Markup:
    """The style or script of all pages, and what one page has of its own.

    Args:
        environment: What renders pages.
        name: The file, ``report.css`` or ``report.js``.
        own: Texts of the page.
    """
    assert environment.loader is not None
    source, *_ = environment.loader.get_source(environment, name)
    return Markup("\n".join(dict.fromkeys([source, *(text for text in own if text)])))


def _heading(title: str) -> Markup:
    """A title of its own, and after it the place in the thesis that it begins with, if any."""
    place, colon, own = title.partition(": ")
    if not (colon and place.startswith(("Figure", "Table", "Section"))):
        return escape(title)
    place = place[0].lower() + place[1:]
    of_thesis = Markup('<small class="theirs">thesis, {}</small>').format(place)
    return Markup("{} {}").format(own[0].upper() + own[1:], of_thesis)


def _kind(part: SectionPart) -> str:
    """How the template shows a part of a section."""
    if isinstance(part, Table):
        return "folded" if part.folded else "table"
    return "figure" if isinstance(part, Figure) else "html"


def _bars(parts: Mapping[str, CellTimes]) -> list[tuple[str, int, str]]:
    """Of each part: its name, share of the longest in percent, and what it took."""
    longest = max((times.seconds for times in parts.values()), default=0.0)
    return [
        (
            name,
            round(100 * times.seconds / longest) if longest else 0,
            f"{number(times.seconds / 60)} min,"
            f" {number(times.seconds / times.cells, digits=2)} s a cell",
        )
        for name, times in sorted(parts.items(), key=lambda part: -part[1].seconds)
    ]
