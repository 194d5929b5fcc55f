"""The leaderboard's page: the entries of `leaderboard/`, side by side."""

from __future__ import annotations

from pathlib import Path

from repository import ROOT, address
from written_pages import write_changed

from avsec_gym.benchmark.entry import ENTRY, Entry, read_entry
from avsec_gym.benchmark.leaderboard import board, left_out
from avsec_gym.benchmark.scene_sets import VERSION
from avsec_gym.drawing.page_table import Table
from avsec_gym.report.leaderboard_page import sortable_table, table_script

ENTRIES = ROOT / "leaderboard"
_HEAD = """# The leaderboard

Which parts keep a car safe under attack? Entries of the frozen [benchmark](benchmark.md), version
{version}, made by `avsec benchmark`. A click on a heading sorts; what the attacker knows, and
whether an adaptive attack breaks an entry, can be picked. How to add one:
[CONTRIBUTING](CONTRIBUTING.md#an-entry-of-the-benchmark).
"""


def write_pages(source: Path, entries: Path = ENTRIES) -> set[Path]:
    """Write it; returns the file.

    Args:
        source: Folder of the site's pages.
        entries: Folder whose folders hold an ``entry.json`` each.

    Raises:
        SystemExit: An entry is not fit for the leaderboard.
    """
    kept = {path: read_entry(path) for path in sorted(entries.glob(f"*/{ENTRY}"))}
    for path, entry in kept.items():
        if reason := left_out(entry):
            raise SystemExit(f"{path} {reason}")
    text = _HEAD.format(version=VERSION)
    for section in board(kept.values()):
        text += f"\n## {section.title}\n\n"
        for part in section.parts:
            assert isinstance(part, Table)
            text += _raw(sortable_table(part))
    text += _files(kept)
    text += _raw(f"<script>\n{table_script()}\n</script>")
    return {write_changed(source / "leaderboard.md", text.encode())}


def _raw(html: str) -> str:
    """HTML that the page takes as it is."""
    return f"`````{{raw}} html\n{html}\n`````\n\n"


def _files(kept: dict[Path, Entry]) -> str:
    """Where all that is recorded of each entry stands."""
    rows = "".join(
        f"| {entry.name} | {entry.kind} | {_link(path)} |\n" for path, entry in kept.items()
    )
    return f"\n## Their files\n\n| entry | kind | all that is recorded |\n|---|---|---|\n{rows}\n"


def _link(path: Path) -> str:
    place = f"{path.parent.name}/{path.name}"
    return f"[{place}]({address(path)})" if path.is_relative_to(ROOT) else place
