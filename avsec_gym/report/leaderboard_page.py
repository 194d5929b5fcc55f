"""The leaderboard of the benchmark as one HTML page."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.benchmark.entry import Entry
from avsec_gym.benchmark.leaderboard import board
from avsec_gym.benchmark.scene_sets import VERSION
from avsec_gym.report.html import joined, page_environment

_QUESTION = "Which parts keep a car safe under attack?"


def leaderboard_page(entries: Sequence[Entry]) -> str:
    """The page; the same bytes for the same entries.

    Args:
        entries: Entries of this version, none of them quick.
    """
    environment = page_environment()
    count = "1 entry" if len(entries) == 1 else f"{len(entries)} entries"
    return environment.get_template("leaderboard.html.j2").render(
        question=_QUESTION,
        extent=f"benchmark, version {VERSION}, {count}",
        sections=board(entries),
        css=joined(environment, "report.css"),
        js=joined(environment, "report.js"),
    )
