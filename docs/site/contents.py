"""What the site holds, and in which order: its sidebar."""

from __future__ import annotations

from collections.abc import Iterable

CONTENTS = {
    "Begin": [
        "start/newcomer",
        "start/rl_researcher",
        "start/perception_researcher",
        "start/security_researcher",
        "start/student",
        "install",
    ],
    "Coming from": [
        "from_highway_env",
        "from_safebench",
        "from_openpcdet",
        "from_art",
    ],
    "Guides": [
        "environments",
        "agents",
        "attacks",
        "detectors",
        "classifiers",
        "average_precision",
        "defences",
        "validation",
        "connected",
        "closed_loop",
        "planner",
        "world",
        "world_made",
        "layouts",
        "data",
        "runs",
        "benchmark",
        "extending",
        "architecture",
    ],
    "Results": [
        "leaderboard",
        "reproduce_chapter3",
        "reproduce_chapter4",
        "reproduce_chapter5",
        "chapter5",
        "studies/README",
    ],
    "Reference": [
        "envs/index",
        "commands",
        "parts",
        "cards/index",
        "api/index",
        "CHANGELOG",
        "CONTRIBUTING",
    ],
}
"""Pages under each heading, without their ending."""


def toctree(pages: Iterable[str], caption: str = "", *, hidden: bool = True) -> str:
    """A block that puts pages into the sidebar, or a list of them on the page as well."""
    options = [f":caption: {caption}"] if caption else []
    options += [":hidden:"] if hidden else [":maxdepth: 1"]
    return "\n".join(["```{toctree}", *options, "", *pages, "```", ""])
