"""Sources of a study: what it imports counts, what it does not import and comments do not."""

from __future__ import annotations

from pathlib import Path

import pytest

from studies.provenance import Record, changed, read_records, sources_of, write_records

FILES = {
    "house/__init__.py": "from house.roof import TILES\n",
    "house/roof.py": "TILES = 3\n",
    "house/cellar/__init__.py": "",
    "house/cellar/shelf.py": 'def apples() -> int:\n    """How many."""\n    return 2\n',
    "house/attic.py": "import house.roof\n",
    "house/weights.bin": "1 2 3",
    "show/run.py": "from neighbour import count\n\nimport json\n",
    "show/neighbour.py": "def count() -> int:\n    from house.cellar.shelf import apples\n"
    "    return apples()\n",
}


@pytest.fixture
def root(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_a_script_brings_in_what_it_imports_and_no_more(root: Path) -> None:
    found = sources_of(["show/run.py", "house/weights.bin"], root)
    # Neither what `house` takes from its roof, past which the import goes, nor the attic.
    assert sorted(found.values()) == [
        "house/cellar/shelf.py", "house/weights.bin", "show/neighbour.py", "show/run.py"
    ]  # fmt: skip
    (root / "house/cellar/shelf.py").write_text("from house import TILES\n")
    assert {"house/__init__.py", "house/roof.py"} <= set(sources_of(["show/run.py"], root).values())
    assert set(sources_of(["house"], root).values()) == {name for name in FILES if "house" in name}


def test_what_the_first_file_names_by_a_string_counts(root: Path) -> None:
    (root / "house/attic.py").write_text('DOOR = "house.cellar.shelf:apples"\n')
    assert "house/cellar/shelf.py" in sources_of(["house/attic.py"], root).values()
    # A registry that everything imports would bring in everything.
    (root / "show/run.py").write_text("import house.attic\n")
    assert "house/cellar/shelf.py" not in sources_of(["show/run.py"], root).values()


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("house/cellar/shelf.py", "def apples() -> int:\n    return 3\n", True),
        ("house/cellar/shelf.py", "def apples() -> int:\n    return 2  # Red.\n", False),
        ("house/cellar/shelf.py", 'def apples() -> int:\n    """Others."""\n    return 2\n', False),
        ("house/attic.py", "import house\n", False),
        ("house/weights.bin", "1 2 4", True),
    ],
)
def test_a_change_of_code_in_the_closure_makes_stale(
    root: Path, name: str, text: str, told: bool
) -> None:
    begin = ["show/run.py", "house/weights.bin"]
    before = sources_of(begin, root)
    (root / name).write_text(text)
    assert changed(before, sources_of(begin, root)) == ([name] if told else [])


def test_sources_that_come_or_go_have_changed(root: Path) -> None:
    before = sources_of(["show/run.py"], root)
    (root / "show/run.py").write_text("import house.attic\n")
    assert changed(before, sources_of(["show/run.py"], root)) == [
        "house/attic.py", "house/cellar/shelf.py", "house/roof.py", "show/neighbour.py",
        "show/run.py",
    ]  # fmt: skip


def test_records_come_back_as_they_were(tmp_path: Path) -> None:
    path = tmp_path / "sources.json"
    records = {
        "old": Record(date="2026-11-21", commit="020f0c9"),
        "new": Record(
            "2026-12-01", "", "0.1.0", "python -m studies.new", 7, {"0a": "a", "0b": "b"}
        ),
        "other": Record("2026-12-02", "", "0.1.0", "python -m studies.other", 9, {"0b": "b"}),
    }
    write_records(records, path)
    assert read_records(path) == records
