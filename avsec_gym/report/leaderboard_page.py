"""The leaderboard of the benchmark as one HTML page."""

from __future__ import annotations

from collections.abc import Sequence

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
