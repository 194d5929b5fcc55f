"""Samples of a legend look like what they stand for."""

from __future__ import annotations

from avsec_gym.drawing.page_figure import line_key, mark_key
from avsec_gym.drawing.page_plots import mark_shape


def test_a_line_keeps_its_colour_and_whether_it_is_dashed() -> None:
    assert line_key("thin line-0", "clean").kind == "line-0"
    assert line_key("thin line-0", "clean").sample == "<i></i>"
    assert line_key("dashed line-1", "attacked").sample == '<i class="dashed"></i>'


def test_a_mark_keeps_its_shape_and_whether_it_is_hollow() -> None:
    key = mark_key("hollow line-1", "the thesis", "square")
    assert (key.kind, key.words) == ("line-1", "the thesis")
    assert 'class="sample hollow"' in key.sample
    assert mark_shape((7, 7), "square") in key.sample
    assert "hollow" not in mark_key("line-1", "ours").sample
    assert 'r="4"' in mark_key("line-1", "ours", size=4).sample
