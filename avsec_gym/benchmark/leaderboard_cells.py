"""Cells that the tables of the leaderboard have in common."""

from __future__ import annotations

from avsec_gym.benchmark.entry import Entry
from avsec_gym.drawing.page_table import UNKNOWN, TableCell, figure, name, number
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.metrics.estimate import Estimate


def entry_cell(entry: Entry) -> TableCell:
    """The entry's name, and what made it."""
    made = f"avsec_gym {entry.made_by.get('avsec_gym', '?')}"
    world = f", world {entry.world}" if entry.world else ""
    return name(entry.name, hint=f"{made}{world}")


def estimate_cell(
    estimate: Estimate | None, *, scale: float = 1.0, signed: bool = False, hint: str = ""
) -> TableCell:
    """A figure with its interval; None: it is unknown."""
    if estimate is None:
        return figure(None)
    return figure(estimate.value, estimate.interval, scale=scale, signed=signed, hint=hint)


def share_cell(share: Share | None) -> TableCell:
    """A share in percent with its interval; None: it is unknown."""
    if share is None:
        return figure(None)
    return figure(share.rate, share.interval, scale=100, hint=f"{share.count} of {share.of}")


def box_cell(white_box: bool | None) -> TableCell:
    """What the attacker knows; None: nothing is attacked, or it is unknown."""
    if white_box is None:
        return name(UNKNOWN)
    return name("white box" if white_box else "black box")


def broken_cell(entry: Entry) -> TableCell:
    """Whether an adaptive attack breaks the entry, and by how much it does better."""
    if entry.broken is None:
        return name(UNKNOWN, hint="no adaptive attack could be tried")
    hint = "; ".join(
        f"{row.setting}: {number(row.difference.value, 100, signed=True) or UNKNOWN} points of"
        f" {row.measure}, against {row.against}"
        for row in entry.adaptive
    )
    if entry.broken:
        return TableCell("yes", hint=hint, tone="bad", words=True)
    return name("no", hint=hint)
