"""An estimate as a cell of a table."""

from __future__ import annotations

from avsec_gym.drawing.page_table import TableCell, figure
from avsec_gym.metrics.estimate import Estimate


def estimate_cell(
    estimate: Estimate, *, scale: float = 1.0, digits: int = 1, signed: bool = False
) -> TableCell:
    """The figure with its interval; arguments as of `figure`."""
    return figure(estimate.value, estimate.interval, scale=scale, digits=digits, signed=signed)
