"""How figures of chapter 4 are written in its tables."""

from __future__ import annotations

from avsec_gym.drawing.page_table import TableCell, figure
from avsec_gym.experiments.chapter4.settings import USUAL
from avsec_gym.experiments.chapter4.summary import ConnectedSummary
from avsec_gym.metrics.clustered_shares import Share

IN_WORDS = {
    "thesis": "surfaces, the thesis’ rule",
    "surfaces": "surfaces (thesis)",
    "rays": "rays",
    "learned": "learned of both",
}
INTERVALS = "In brackets: 95 % intervals, which know that regions of one instant are alike"


def percent(share: Share, thesis: float | None = None) -> TableCell:
    """A share in percent, with its interval.

    Args:
        share: The share.
        thesis: The thesis' figure, from 0 to 1; None: it has none.
    """
    return figure(share.rate, share.interval, thesis, scale=100)


def shown_condition(summary: ConnectedSummary) -> str:
    """The condition of tables of a single one: the usual errors, or the first that was measured."""
    return USUAL.name if USUAL.name in summary.instants else next(iter(summary.instants))
