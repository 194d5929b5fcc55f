"""Which tables of a section stand in the text."""

from __future__ import annotations

from avsec_gym.drawing.page_figure import Figure
from avsec_gym.drawing.page_table import Table
from avsec_gym.runs.section import Section


def test_the_text_has_the_tables_of_the_page_unless_others_are_named() -> None:
    first, second = Table("First", ["a"], []), Table("Second", ["b"], [])
    parts = [first, Figure("Drawn"), second]
    assert Section("id", "Title", parts=parts).tables == [first, second]
    assert Section("id", "Title", parts=parts, text_tables=[second]).tables == [second]
    assert Section("id", "Title", parts=parts, text_tables=()).tables == []
