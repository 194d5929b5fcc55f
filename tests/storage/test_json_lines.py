"""Rows that are kept one by one, and what a process that was stopped leaves of them."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import Any, Literal, TypedDict

import pytest

from avsec_gym.errors import DataError
from avsec_gym.storage.json_lines import JsonLines


class Row(TypedDict):
    id: str


class End(StrEnum):
    GOAL = "goal"
    TIME = "time"


class Place(TypedDict, total=False):
    x: float
    name: str


class Measured(TypedDict):
    id: str
    count: int
    share: float | None
    end: End
    kind: Literal["a", "b"]
    places: list[Place]


MEASURED: dict[str, Any] = {
    "id": "a", "count": 3, "share": 0.5, "end": "goal", "kind": "b", "places": [{"x": 1}, {}],
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "value", "is_one"),
    [
        ("count", 3.5, False),
        ("count", True, False),
        ("count", None, False),
        ("share", None, True),
        ("share", 1, True),
        ("share", "0.5", False),
        ("end", "time", True),
        ("end", "gaol", False),
        ("end", ["goal"], False),
        ("kind", "c", False),
        ("places", {"x": 1}, False),
        ("places", [{"x": "far"}], False),
        ("places", [{"name": "here", "more": 2}], True),
        ("places", [3], False),
    ],
)
def test_a_line_has_the_fields_that_its_reader_relies_on(
    name: str, value: Any, is_one: bool, tmp_path: Path
) -> None:
    path = tmp_path / "rows.jsonl"
    lines = [MEASURED, {**MEASURED, "id": "b", name: value}]
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    if is_one:
        assert JsonLines(path, Measured).rows["b"][name] == value
    else:
        with pytest.raises(DataError, match=rf"rows\.jsonl: Line 2 is damaged \({name} is"):
            JsonLines(path, Measured)


@pytest.mark.parametrize("name", [name for name in MEASURED if name != "id"])
def test_a_line_without_one_of_them_is_damaged(name: str, tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_text(json.dumps({key: MEASURED[key] for key in MEASURED if key != name}) + "\n")
    with pytest.raises(DataError, match=rf"Line 1 is damaged \(it lacks {name}\)"):
        JsonLines(path, Measured)


def test_rows_are_on_the_disk_at_once_and_read_again(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    lines = JsonLines(path, Row)
    for number, id in enumerate("ab"):
        lines.add({"id": id, "measured": [number / 3]})
        assert JsonLines(path, Row).rows == lines.rows
    assert list(lines.rows) == ["a", "b"]
    assert JsonLines(path, Row).rows["b"]["measured"] == [1 / 3]


def test_a_last_line_that_was_cut_off_is_dropped(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_text('{"id": "a"}\n{"id": "b"')
    lines = JsonLines(path, Row)
    assert list(lines.rows) == ["a"]
    lines.add({"id": "c"})
    assert list(JsonLines(path, Row).rows) == ["a", "c"]


@pytest.mark.parametrize("line", ['{"id": "b"', '{"name": "b"}', '{"id": 2}', "[]"])
def test_another_line_that_is_damaged_is_named(tmp_path: Path, line: str) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_text(f'{{"id": "a"}}\n{line}\n{{"id": "c"}}\n')
    with pytest.raises(DataError, match=r"rows\.jsonl: Line 2 is damaged"):
        JsonLines(path, Row)


def test_without_a_file_rows_stay_in_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    lines = JsonLines(None, Row)
    lines.add({"id": "a"})
    assert list(lines.rows) == ["a"]
    assert not list(tmp_path.iterdir())
