"""Pages of the documentation that show results: their blocks are made from the results."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from avsec_gym.storage.text_files import read_text
from studies.chapter4.methods_table import methods_table
from studies.driving_safety.closed_loop_film import film_lines
from studies.driving_safety.ego_motion import ego_motion_lines
from studies.driving_safety.ghost_places_table import ghost_places_table
from studies.generated_blocks import with_blocks
from studies.reproduce.chapter3 import chapter3_rows
from studies.reproduce.chapter4 import chapter4_rows
from studies.reproduce.chapter5 import chapter5_rows
from studies.reproduce.page import judged, rule_lines, summary_lines, table_lines
from studies.reproduce.rows import ThesisRow
from studies.source_states import SourceState
from studies.study import ROOT
from studies.world.layout_tables import distances_table, goals_table, objects_table

_CURRENT = re.compile(r"`python -m studies\.(\w+)[^`|]*` \| current \|")
"""The study of a row that calls its sources current."""
Blocks = Mapping[str, Sequence[str]]
"""Name -> lines."""

_CHAPTERS: dict[str, Callable[[], list[ThesisRow]]] = {
    "docs/reproduce_chapter3.md": chapter3_rows,
    "docs/reproduce_chapter4.md": chapter4_rows,
    "docs/reproduce_chapter5.md": chapter5_rows,
}
_TABLES: dict[str, dict[str, Callable[[], list[str]]]] = {
    "docs/closed_loop.md": {"ego motion": ego_motion_lines, "film": film_lines},
    "docs/connected.md": {"methods": methods_table},
    "docs/environments.md": {"ghost places": ghost_places_table},
    "docs/layouts.md": {
        "distances": distances_table,
        "objects": objects_table,
        "goals": goals_table,
    },
}


def docs_pages(states: Mapping[str, SourceState], root: Path = ROOT) -> dict[Path, str]:
    """File -> what has to be in it.

    Args:
        states: Today's state of studies.
        root: Root of the checkout whose pages are filled.

    Raises:
        DataError: A page has other blocks than are made, or a result has not the field of one.
    """
    blocks: dict[str, Blocks] = {
        page: {name: table() for name, table in tables.items()} for page, tables in _TABLES.items()
    }
    blocks |= {page: _chapter(rows(), states) for page, rows in _CHAPTERS.items()}
    return {root / page: with_blocks(read_text(root / page), made) for page, made in blocks.items()}


def docs_called_current(states: Mapping[str, SourceState], root: Path = ROOT) -> list[str]:
    """Pages of chapters with a row that calls sources current which are not.

    Args:
        states: Today's state of studies.
        root: Root of the checkout.
    """
    return [
        page
        for page in _CHAPTERS
        if (root / page).is_file()
        and any(
            states[name].stale is not False for name in _CURRENT.findall(read_text(root / page))
        )
    ]


def _chapter(rows: Sequence[ThesisRow], states: Mapping[str, SourceState]) -> Blocks:
    found = [judged(row, states) for row in rows]
    return {
        "rule": rule_lines(),
        "counts": summary_lines(found),
        "rows": table_lines(found, states),
    }
