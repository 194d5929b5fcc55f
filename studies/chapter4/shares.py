"""Shares in the tables of chapter 4's studies."""

from __future__ import annotations

from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.report.markdown_table import UNKNOWN, number


def percent(share: Share) -> str:
    """A share in percent with its interval and the number of cases.

    Example:
        >>> percent(Share.of_counts(1, 4))
        '25.0 [4.6, 69.9] of 4'
    """
    if share.rate is None or share.interval is None:
        return UNKNOWN
    low, high = (number(100 * bound, 1) for bound in share.interval)
    return f"{number(share.percent, 1)} [{low}, {high}] of {share.of}"
