"""Each plug-in is one short file of one folder, and the documentation shows these very files."""

from __future__ import annotations

import ast

import pytest

from tests.plugins.conftest import PACKAGE, ROOT

FILES = sorted((PACKAGE / "avsec_others").glob("*.py"))
PAGE = ROOT / "docs" / "extending.md"


@pytest.mark.parametrize("name", [file.name for file in FILES])
def test_it_has_less_than_sixty_lines(name: str) -> None:
    assert len((PACKAGE / "avsec_others" / name).read_text().splitlines()) < 60


def test_there_is_one_of_each_kind_of_part_and_nothing_else() -> None:
    assert [file.name for file in FILES] == [
        "__init__.py", "lane_change.py", "passing_distance.py", "shifted_image.py",
        "stereo_and_scan.py", "stereo_clusters.py", "worst_shift.py",
    ]  # fmt: skip


@pytest.mark.parametrize("file", ["../pyproject.toml", *(file.name for file in FILES)])
def test_the_page_shows_it(file: str) -> None:
    text = (PACKAGE / "avsec_others" / file).resolve().read_text()
    language = "toml" if file.endswith("toml") else "python"
    if language == "toml":
        text = text.partition("\n\n")[2]  # The build system is what every package has.
    assert f"```{language}\n{text}```\n" in PAGE.read_text()


def test_they_use_public_names_only() -> None:
    for file in FILES:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom):
                assert not any(alias.name.startswith("_") for alias in node.names)
