"""A class is found by its name: no two modules of the package have a public one alike."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[1]
TWICE: dict[str, str] = {}
"""Names that may stand in several modules, and why."""


def repeated(sources: Mapping[str, str]) -> dict[str, list[str]]:
    """Public classes of one name in several modules: the name -> their places.

    Args:
        sources: The text of each module by its place.
    """
    places = defaultdict(list)
    for place, source in sources.items():
        for node in ast.parse(source).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(place)
    return {name: found for name, found in places.items() if len(found) > 1}


def test_classes_of_one_name_are_found() -> None:
    sources = {
        "a.py": "class Look: pass\nclass _Rows: pass\nclass Plan:\n    class Step: pass",
        "b/c.py": "from a import Plan\nclass _Rows: pass\nclass Step: pass\nclass Look: pass",
    }
    assert repeated(sources) == {"Look": ["a.py", "b/c.py"]}


def test_a_public_class_has_its_name_alone() -> None:
    sources = {
        path.relative_to(ROOT).as_posix(): path.read_text()
        for path in (ROOT / "avsec_gym").rglob("*.py")
    }
    found = repeated(sources)
    assert found.keys() == TWICE.keys(), found
