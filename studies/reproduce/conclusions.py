"""The rule that compares a value of the thesis with ours: nothing of it is typed by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from avsec_gym.metrics.estimate import Estimate
from studies.reproduce.rows import Claim, DataKind, Unit

WIDEST = {Unit.SHARE: 0.1, Unit.PERCENT: 10.0, Unit.NUMBER: 0.6}
"""An interval that is wider than this, and holds the thesis' value, decides nothing."""
LEAST_CLUSTERS = 5
"""What is measured on fewer frames, drives or scenes decides nothing."""


class ClaimDecision(Enum):
    """What one measurement decides of a value of the thesis."""

    CONFIRMED = "confirmed"
    CONTRADICTED = "contradicted"
    NOT_MEASURED = "not measured yet"
    NO_INTERVAL = "no interval"
    TOO_FEW = "too few cases"
    TOO_WIDE = "the interval is too wide"

    @property
    def decides(self) -> bool:
        """Whether it is one of the first two."""
        return self in (ClaimDecision.CONFIRMED, ClaimDecision.CONTRADICTED)


@dataclass(frozen=True)
class Decided:
    """What a measurement decides, and what it is.

    Args:
        decision: What it decides.
        kind: What data it is measured on.
        experiment: What measures it.
        where: Its parameters.
        state: The state of its sources, in a word: ``current``, ``stale`` or ``not made yet``.
    """

    decision: ClaimDecision
    kind: DataKind
    experiment: str
    where: str = ""
    state: str = "current"


def decision(
    claim: Claim, thesis: float, ours: Estimate | None, widest: float, clusters: int | None = None
) -> ClaimDecision:
    """Hold an estimate against a value of the thesis.

    A value beyond the interval is contradicted, unless the thesis bounds it from one side and the
    interval lies on that side: then it is confirmed.  A value within the interval is confirmed if
    the interval is narrow enough to have contradicted it.

    Args:
        claim: How the value is meant.
        thesis: The value.
        ours: Our estimate; None: not measured yet.
        widest: The widest interval that confirms a value within it.
        clusters: The number of clusters; None: it is large.

    Example:
        >>> decision(Claim.AT_LEAST, 0.9, Estimate(0.97, (0.95, 0.98)), 0.1).value
        'confirmed'
        >>> decision(Claim.IS, 0.9, Estimate(0.97, (0.95, 0.98)), 0.1).value
        'contradicted'
    """
    if ours is None or ours.value is None:
        return ClaimDecision.NOT_MEASURED
    if clusters is not None and clusters < LEAST_CLUSTERS:
        return ClaimDecision.TOO_FEW
    if ours.interval is None:
        return ClaimDecision.NO_INTERVAL
    low, high = ours.interval
    if low <= thesis <= high:
        return ClaimDecision.CONFIRMED if high - low <= widest else ClaimDecision.TOO_WIDE
    agrees = {Claim.IS: False, Claim.AT_LEAST: low > thesis, Claim.AT_MOST: high < thesis}
    return ClaimDecision.CONFIRMED if agrees[claim] else ClaimDecision.CONTRADICTED


def conclusion(decided: Sequence[Decided]) -> str:
    """The conclusion on a row, of what its measurements decide.

    The weightiest kind of data on which anything is decided decides alone: real before twin before
    procedural.

    Args:
        decided: One for each measurement.

    Example:
        >>> small = Decided(ClaimDecision.CONFIRMED, DataKind.TWIN, "patch", "small discs")
        >>> large = Decided(ClaimDecision.CONTRADICTED, DataKind.TWIN, "patch", "large ones")
        >>> conclusion([small, large])
        'confirmed where small discs; contradicted where large ones, by `patch` (twin)'
    """
    for kind in DataKind:
        deciding = [each for each in decided if each.kind is kind and each.decision.decides]
        if deciding:
            return _of_kind(deciding)
    reasons = dict.fromkeys(each.decision.value for each in decided)
    return f"open ({'; '.join(reasons) or ClaimDecision.NOT_MEASURED.value})"


def _of_kind(deciding: Sequence[Decided]) -> str:
    """The conclusion of measurements on one kind of data, each of which decides."""
    confirmed = [each for each in deciding if each.decision is ClaimDecision.CONFIRMED]
    contradicted = [each for each in deciding if each.decision is ClaimDecision.CONTRADICTED]
    states = sorted({each.state for each in deciding} - {"current"})
    basis = f"({', '.join([deciding[0].kind.value, *states])})"
    if not contradicted:
        return f"confirmed {basis}"
    experiments = ", ".join(dict.fromkeys(f"`{each.experiment}`" for each in contradicted))
    if not confirmed:
        return f"contradicted by {experiments} {basis}"
    return (
        f"confirmed where {_places(confirmed)}; contradicted where {_places(contradicted)},"
        f" by {experiments} {basis}"
    )


def _places(decided: Sequence[Decided]) -> str:
    return ", ".join(each.where for each in decided)
