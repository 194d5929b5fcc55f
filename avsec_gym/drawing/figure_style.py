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
"""For `matplotlib.rc_context`, whose keys have a type of their own."""
