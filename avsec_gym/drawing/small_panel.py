"""The small panel of which several stand beside each other: its size, its frame and its axes."""

from __future__ import annotations

from avsec_gym.drawing.page_plots import Frame, Scale, text

WIDTH, HEIGHT = 250, 176
"""The size of a panel, pixels."""
X_ENDS, Y_ENDS = (34.0, 240.0), (142.0, 26.0)
"""Where the axes begin and end, pixels."""


def panel_frame(right: float, top: float) -> Frame:
    """A frame from 0 on, to the right and upwards."""
    return Frame(Scale(0, right, *X_ENDS), Scale(0, top, *Y_ENDS))


def panel_axes(frame: Frame, title: str, below: str) -> list[str]:
    """The axes with their ticks, a title above and what the horizontal axis shows."""
    return [
        frame.axes(frame.x.ticks(4), frame.y.ticks(4)),
        text((frame.x.start, 14), title, "name"),
        text(((frame.x.start + frame.x.end) / 2, HEIGHT - 2), below, "middle"),
    ]
