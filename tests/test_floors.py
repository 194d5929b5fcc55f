"""The floors where import-linter does not look: strings, and scripts beside the package."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import avsec_gym.world

ROOT = Path(__file__).parents[1]
WORLD = "avsec_gym.world."
INSIDE_THE_WORLD = {
    "benchmarks/fuzz/kinds.py",  # Broken files: how they are written and read one by one.
    "benchmarks/fuzz/sound_files.py",
    "benchmarks/fuzz/world_files.py",
    "examples/plain_with_cars.py",  # A place of boxes, which the world has none of.
}
"""Scripts that look inside of the world, and why."""
CATALOGUES = {
    "built_in_parts.py",  # Parts of the pipeline.
    "registration.py",  # Environments.
    "runs/catalogue.py",  # Experiments,
    "runs/renamed.py",  # and their old places.
    "scenario/contested_sets.py",  # Sets of scenes that are chosen by driving.
}
"""The only modules of the package that name others of higher floors, by entry points."""


def contract(name: str) -> dict[str, Any]:
    """A contract of import-linter, by its name."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())
    contracts = settings["tool"]["importlinter"]["contracts"]
    return next(each for each in contracts if each["name"] == name)


def floors() -> dict[str, int]:
    """The number of each floor, from the ground up."""
    layers = reversed(contract("An import points to a lower floor")["layers"])
    return {name: number for number, layer in enumerate(layers) for name in layer.split(" : ")}


def higher_ones(place: str, source: str) -> list[str]:
    """The modules of higher floors that a module's strings name; docstrings may name any.

    Args:
        place: The module's path in the package, such as ``scenario/scene_sets.py``.
        source: Its text.
    """
    known = floors()
    own = known.get(place.split("/")[0].removesuffix(".py"), len(known))
    tree = ast.parse(source)
    docstrings = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    return [
        found[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        if id(node) not in docstrings
        for found in re.finditer(r"\bavsec_gym\.(\w+)[\w.]*", node.value)
        if known.get(found[1], 0) > own
    ]


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


@pytest.mark.parametrize(
    ("place", "source", "found"),
    [
        ("scenario/a.py", 'NAME = "avsec_gym.evaluation.contested"', ["evaluation.contested"]),
        ("world/a/b.py", 'load(f"avsec_gym.envs.x:{name}")', ["envs.x"]),
        ("boxes.py", 'A = {"b": ("avsec_gym.planners.planner:Planner", {})}', ["planners.planner"]),
        ("scenario/a.py", 'NAME = "avsec_gym.kitti.raw", "avsec_gym.scenario.b:C"', []),
        ("scenario/a.py", '"""See `avsec_gym.envs.x`."""\nA = 1\n"""`avsec_gym.envs.x`."""', []),
    ],
)
def test_strings_that_name_higher_floors_are_found(
    place: str, source: str, found: list[str]
) -> None:
    assert higher_ones(place, source) == [f"avsec_gym.{each}" for each in found]


def test_only_catalogues_name_modules_of_higher_floors() -> None:
    package = ROOT / "avsec_gym"
    sources = {
        path.relative_to(package).as_posix(): path.read_text() for path in package.rglob("*.py")
    }
    assert {place for place, source in sources.items() if higher_ones(place, source)} == CATALOGUES
