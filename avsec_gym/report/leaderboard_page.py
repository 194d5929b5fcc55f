"""The leaderboard of the benchmark as one HTML page, and its tables for another one."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from avsec_gym.drawing.page_table import Table
from avsec_gym.report.html import joined, page_environment
from avsec_gym.runs.section import Section

_QUESTION = "Which parts keep a car safe under attack?"


def leaderboard_page(sections: Sequence[Section], extent: str) -> str:
    """The page; the same bytes for the same sections.

    Args:
        sections: A section for each kind of entry.
        extent: What the page is of, such as ``version 1, 4 entries``.
    """
    environment = page_environment()
    return environment.get_template("leaderboard.html.j2").render(
        question=_QUESTION,
        extent=extent,
        sections=sections,
        css=joined(environment, "report.css"),
        js=joined(environment, "report.js"),
    )


def sortable_table(table: Table, heading: str = "h3") -> str:
    """A table of the leaderboard as HTML without empty lines, for a page that has the script.

    Args:
        table: The table.
        heading: The element of its title.
    """
    sheet = page_environment().get_template("table.html.j2").module.sheet  # type: ignore[attr-defined]
    lines = str(sheet(table, heading)).splitlines()
    return "\n".join(line for line in lines if line.strip())


def table_script() -> Markup:
    """What sorts and filters the tables of a page."""
    return joined(page_environment(), "report.js")
