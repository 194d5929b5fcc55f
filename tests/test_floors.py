"""The floors where import-linter does not look: strings, and scripts beside the package."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import avsec_gym.world

ROOT = Path(__file__).parents[1]
WORLD = "avsec_gym.world."
INSIDE_THE_WORLD = {
    "benchmarks/fuzz/kinds.py",  # Broken files: how they are written and read one by one.
    "benchmarks/fuzz/sound_files.py",
    "benchmarks/fuzz/world_files.py",
    "examples/connected_sockets.py",  # A place of boxes, which the world has none of.
}
"""Scripts that look inside of the world, and why."""


def contract(name: str) -> dict[str, Any]:
    """A contract of import-linter, by its name."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())
    contracts = settings["tool"]["importlinter"]["contracts"]
    return next(each for each in contracts if each["name"] == name)


def doors() -> set[str]:
    """The world's modules that may be imported from outside, according to the contract."""
    found = contract("The world is entered through its doors")["ignore_imports"]
    return {each.removeprefix("** -> ") for each in found if each.startswith("** -> ")}


def imported(source: str) -> Iterator[str]:
    """The modules that a source imports names from."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
        elif isinstance(node, ast.Import):
            yield from (each.name for each in node.names)


def test_the_docstring_and_the_page_of_the_world_list_its_doors() -> None:
    listed = re.findall(r"^- `(\w+)`:", avsec_gym.world.__doc__ or "", re.MULTILINE)
    assert {WORLD + name for name in listed} == doors()
    page = (ROOT / "docs/world.md").read_text()
    assert set(re.findall(r"^\| `(avsec_gym\.world\.\w+)` \|", page, re.MULTILINE)) == doors()


def test_scripts_and_pages_enter_the_world_through_its_doors() -> None:
    sources = {
        path: path.read_text()
        for folder in ("benchmarks", "examples", "docs")
        for path in (ROOT / folder).rglob("*.py")
    }
    for page in (ROOT / "docs").rglob("*.md"):
        # Blocks may be cut off in the middle: their lines of imports are looked at.
        lines = re.findall(r"^from avsec_gym\.\S+ import \w+", page.read_text(), re.MULTILINE)
        sources[page] = "\n".join(lines)
    inside = {
        path.relative_to(ROOT).as_posix()
        for path, source in sources.items()
        if any(each.startswith(WORLD) and each not in doors() for each in imported(source))
    }
    assert inside == INSIDE_THE_WORLD
