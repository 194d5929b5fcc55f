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
        'text = "was it noticed?"', 'text = "the car may notice"', "# Anybody may read it.",
        "class LaserShot: ...", "def worth_a_shot() -> None: ...", "class Stage: ...",
        "async def desk_of() -> None: ...", "class Drive: ...",
        "found = [one.id for one in frames]", "VERDICT = 1",
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


@pytest.mark.parametrize("line", ["momentum = mass * speed", "unknowing = 1", "noticeable = 2"])
def test_other_words_are_not(words: ModuleType, line: str) -> None:
    assert list(words.found(line)) == []


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("drawing/page.py", "def screenshot() -> None: ..."),
        ("drawing/page.py", "a = 1  # The second stage, at one shot."),
        ("avsec_gym/perception/nn/resnet.py", "def residual_stages() -> None: ..."),
        ("avsec_gym/perception/nn/resnet.py", "def residual_stage() -> None: ..."),
        ("avsec_gym/kitti/raw.py", "class Drive: ..."),
        ("avsec_gym/closed_loop/light/light_drive.py", "class Drives: ..."),
        ("avsec_gym/drives/one_drive.py", "class Drive(Recording): ..."),
    ],
)
def test_names_of_the_field_are_not(words: ModuleType, path: str, line: str) -> None:
    assert list(words.names_of(path, line)) == []


def test_a_module_has_a_name_too(words: ModuleType) -> None:
    found = [name for _, name, _ in words.names_of("examples/laser_shots.py", "")]
    assert found == ["laser_shots"]


def test_a_field_is_described_with_its_noun(words: ModuleType) -> None:
    code = 'class A:\n    seed: int\n    """Of the draws."""\n    b: int\n    """A number."""\n'
    assert list(words.without_subject(code)) == [(3, "Of")]


@pytest.mark.parametrize(
    ("description", "found"),
    [
        ("That looks.", "That"), ("Of the vehicle that looks.", "Of"), ("See `Rig`.", "See"),
        ("Makes the sensors.", "Makes"), ("Called with each.", "Called"), ("Metres.", "Metres."),
        ("The sensors of the vehicle that looks.", None), ("Metres ahead of the car.", None),
        ("How many metres lie ahead, see\n            `Rig`.", None),
    ],
)  # fmt: skip
def test_an_argument_is_described_with_its_noun(
    words: ModuleType, description: str, found: str | None
) -> None:
    code = f'''
class A:
    """A look.

    Args:
        rig: {description}

    Raises:
        DataError: In this case nothing is read.
    """
'''
    assert list(words.without_subject(code)) == ([(6, found)] if found else [])
    assert list(words.without_subject(code, docstrings=False)) == []


def test_a_summary_begins_with_its_noun(words: ModuleType) -> None:
    code = 'def {}() -> None:\n    """{}"""\n'
    assert list(words.without_subject(code.format("f", "Of this, nothing."))) == [(2, "Of")]
    assert list(words.without_subject(code.format("_f", "Of this, nothing."))) == []
    assert list(words.without_subject(code.format("f", "In which regions cars stand."))) == []


def test_the_sources_of_data_sets_are_left_as_they_are(
    words: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(words, "ROOT", tmp_path)
    places = ("avsec_gym/world/sun.py", "avsec_gym/rig.py", "avsec_gym/hub.py", "studies/study.py")
    for place in places:
        file = tmp_path / place
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text('def sun() -> float:\n    """In degrees."""\n    return 0.0\n')
    complaints = words.complaints(tmp_path / place for place in places)
    assert [each.partition(":")[0] for each in complaints] == [
        "avsec_gym/hub.py",
        "studies/study.py",
    ]


@pytest.mark.parametrize("name", ["page.js", "page.css", "page.html", "page.html.j2", "a.ipynb"])
def test_pages_and_notebooks_are_read(
    words: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setattr(words, "ROOT", tmp_path)
    (tmp_path / "avsec_gym").mkdir()
    (tmp_path / "avsec_gym" / name).write_text("/* Somebody opens it. */")
    for page in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"):
        (tmp_path / page).write_text("")
    assert words.complaints(words.files_of_rooms()) == [
        f"avsec_gym/{name}:1: 'somebody': say the attacker, or a user"
    ]


def test_every_allowed_use_is_there(words: ModuleType) -> None:
    for path, word in words.ALLOWED:
        there = {found for _, found in words.found((ROOT / path).read_text())}
        assert word in there, f"{path} no longer needs its exception"
