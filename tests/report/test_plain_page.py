"""A page of sections that belong to no run."""

from __future__ import annotations

from avsec_gym.report.plain_page import plain_page
from avsec_gym.runs.section import Section


def test_many_findings_are_a_list_and_few_are_a_paragraph() -> None:
    few = [f"Finding {number}." for number in range(3)]
    page = plain_page("Asked", "a test", [Section("some", "Some", few, [], context="So many.")])
    assert "<p>Finding 0. Finding 1. Finding 2. So many.</p>" in page
    assert "<li>" not in page

    many = [*few, "Is 3 < 4?"]
    page = plain_page("Asked", "a test", [Section("some", "Some", many, [], context="So many.")])
    assert page.count("<li>") == 4
    assert "<li>Is 3 &lt; 4?</li>" in page
    assert "<p>So many.</p>" in page
