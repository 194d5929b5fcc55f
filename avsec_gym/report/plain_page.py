"""A page of a few sections that belong to no run."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.report.html import joined, page_environment
from avsec_gym.runs.section import Section


def plain_page(
    title: str, made_by: str, sections: Sequence[Section], style: str = "", script: str = ""
) -> str:
    """The page.

    Args:
        title: Its heading.
        made_by: What made it, such as ``avsec demo``.
        sections: What stands on it.
        style: CSS that the sections need.
        script: JavaScript that they need.
    """
    environment = page_environment()
    return environment.get_template("plain.html.j2").render(
        title=title,
        made_by=made_by,
        sections=sections,
        css=joined(environment, "report.css", [style]),
        js=joined(environment, "report.js", [script]),
    )
