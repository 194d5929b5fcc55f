"""The words that rooms have left behind stay out of them."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def words() -> ModuleType:
    spec = importlib.util.spec_from_file_location("words", ROOT / "docs" / "words.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_rooms_hold_none(words: ModuleType) -> None:
    files = words.files_of_rooms()
    assert len(files) > 900
    assert words.complaints(files) == []


@pytest.mark.parametrize(
    "line",
    [
        "def of_moment() -> None: ...", "class RepairedMoments: ...", "# Nobody knows it.",
        'text = "was it noticed?"', "found = [one.id for one in frames]", "VERDICT = 1",
    ],
)  # fmt: skip
def test_an_added_word_is_found(
    words: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: str
) -> None:
    monkeypatch.setattr(words, "ROOT", tmp_path)
    (tmp_path / "module.py").write_text(f'"""A module."""\n\n{line}\n')
    [complaint] = words.complaints([tmp_path / "module.py"])
    assert complaint.startswith("module.py:3: ")


def test_tests_may_have_words_that_the_package_may_not(
    words: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(words, "ROOT", tmp_path)
    (tmp_path / "tests").mkdir()
    for room in ("tests", "."):
        (tmp_path / room / "module.py").write_text("told = 1\nverdict = 2\n")
    inside, outside = tmp_path / "tests" / "module.py", tmp_path / "module.py"
    assert [line.split(":")[1] for line in words.complaints([inside])] == ["2"]
    assert [line.split(":")[1] for line in words.complaints([outside])] == ["1", "2"]


@pytest.mark.parametrize("line", ["momentum = mass * speed", "unknowing = 1", "notice = board()"])
def test_other_words_are_not(words: ModuleType, line: str) -> None:
    assert list(words.found(line)) == []


def test_every_allowed_use_is_there(words: ModuleType) -> None:
    for path, word in words.ALLOWED:
        there = {found for _, found in words.found((ROOT / path).read_text())}
        assert word in there, f"{path} no longer needs its exception"
