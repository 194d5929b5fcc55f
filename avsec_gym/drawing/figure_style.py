"""How figures look: quiet axes, one typeface."""

from __future__ import annotations

from typing import Any

INK, FAINT = "#222222", "#6B6B6B"
"""Colours of text that matters, and of axes."""

FIGURE_STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.edgecolor": "#999999",
    "axes.linewidth": 0.8,
    "text.color": INK,
    "axes.labelcolor": FAINT,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
}
"""Figure style for `matplotlib.rc_context`, whose keys have a type of their own."""


def as_drawn(name: str) -> str:
    r"""A name that users or their files gave, as matplotlib draws it letter for letter.

    Dollars are no formula, and bytes that are no text of the locale are shown as escapes.

    Example:
        >>> as_drawn("5$ or 6$")
        '5\\$ or 6\\$'
    """
    return as_text(name).replace("$", r"\$")


def as_text(name: str) -> str:
    """A name without what no typeface has: bytes that are no text are shown as escapes."""
    return name.encode("utf-8", "backslashreplace").decode()
