"""Rows that are kept one by one, and what a process that was stopped leaves of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.storage.json_lines import JsonLines


def test_rows_are_on_the_disk_at_once_and_read_again(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    lines = JsonLines(path)
    for number, id in enumerate("ab"):
        lines.add({"id": id, "measured": [number / 3]})
        assert JsonLines(path).rows == lines.rows
    assert list(lines.rows) == ["a", "b"]
    assert JsonLines(path).rows["b"]["measured"] == [1 / 3]


def test_a_last_line_that_was_cut_off_is_dropped(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_text('{"id": "a"}\n{"id": "b"')
    lines = JsonLines(path)
    assert list(lines.rows) == ["a"]
    lines.add({"id": "c"})
    assert list(JsonLines(path).rows) == ["a", "c"]


@pytest.mark.parametrize("line", ['{"id": "b"', '{"name": "b"}', '{"id": 2}', "[]"])
def test_another_line_that_is_damaged_is_named(tmp_path: Path, line: str) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_text(f'{{"id": "a"}}\n{line}\n{{"id": "c"}}\n')
    with pytest.raises(DataError, match=r"rows\.jsonl: Line 2 is damaged"):
        JsonLines(path)


def test_without_a_file_rows_stay_in_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    lines = JsonLines()
    lines.add({"id": "a"})
    assert list(lines.rows) == ["a"]
    assert not list(tmp_path.iterdir())
