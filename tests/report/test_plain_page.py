"""A page of sections that belong to no run."""

from __future__ import annotations

from avsec_gym.drawing.page_figure import CaptionedImage, Figure, PictureRow
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


def test_a_moving_picture_has_a_still_for_who_asks_for_less_motion() -> None:
    moving = CaptionedImage("data:moving", "Ends well", "A film", still="data:still")
    row = PictureRow([moving, CaptionedImage("data:image", "An image", "It")], "pair")
    page = plain_page(
        "Asked", "a test", [Section("some", "Some", [], [Figure("f", pictures=[row])])]
    )
    source = '<source media="(prefers-reduced-motion: reduce)" srcset="data:still">'
    assert f'<picture>{source}<img src="data:moving" alt="A film"></picture>' in page
    assert '<figure><img src="data:image" alt="It"><figcaption>' in page
