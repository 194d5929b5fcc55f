"""Scales of drawings."""

from __future__ import annotations

from avsec_gym.drawing.page_plots import Scale, limits


def test_scales_have_round_ticks() -> None:
    assert Scale(-2.3, 41.0, 0, 100).ticks() == [0, 10, 20, 30, 40]
    assert Scale(0, 1, 0, 100).ticks(4) == [0, 0.25, 0.5, 0.75, 1]
    assert Scale(0, 10, 100, 0)(2.5) == 75
    low, high = limits([3.0, None, 20.0])
    assert low < 0 < 20 < high
