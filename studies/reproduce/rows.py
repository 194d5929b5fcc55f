"""What the thesis states, and where our measurement of it stands."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from studies.result_fields import ResultField


class DataKind(Enum):
    """What data a figure of ours is measured on, the weightiest first."""

    REAL = "real"
    TWIN = "twin"
    PROCEDURAL = "procedural"


class Claim(Enum):
    """How the thesis means a value."""

    IS = "is"
    AT_LEAST = "at least"
    AT_MOST = "at most"


class Unit(Enum):
    """What a value is a number of."""

    SHARE = "share"
    """A share of 1, shown in percent."""
    PERCENT = "percent"
    NUMBER = "number"

    @property
    def shown(self) -> float:
        """What a value is multiplied by where it is shown."""
        return 100.0 if self is Unit.SHARE else 1.0

    @property
    def sign(self) -> str:
        """What stands behind a value that is shown."""
        return "" if self is Unit.NUMBER else " %"


MOST = 0.5
NEARLY_ALL = 0.95
"""How words of the thesis are read: "most" is half or more, "nearly all" 95 % or more."""


@dataclass(frozen=True)
class Measured:
    """A measurement of ours.

    Args:
        value: Where it stands.
        kind: What data it is measured on.
        experiment: The experiment, or the module, that measures it.
        where: Parameters that the thesis leaves open, or in which measurements of one row differ.
        interval: Where its 95 % interval stands.
        cases: Where the number of independent cases of a share stands, of which Wilson's interval
            is made where the result holds none.
        clusters: Where the number of clusters stands, or a list with one item of each; None: it
            is large.
    """

    value: ResultField
    kind: DataKind
    experiment: str
    where: str = ""
    interval: ResultField | None = None
    cases: ResultField | None = None
    clusters: ResultField | None = None


def measured(
    place: ResultField,
    kind: DataKind,
    experiment: str,
    where: str = "",
    value: str = "rate",
    interval: str = "interval",
    clusters: ResultField | None = None,
) -> Measured:
    """A measurement whose value and interval stand side by side in one row of a result.

    Args:
        place: The row.
        kind: What data it is measured on.
        experiment: What measures it.
        where: Parameters that the thesis leaves open, see `Measured`.
        value: The column of the value.
        interval: The column of the interval.
        clusters: Where the number of clusters stands, see `Measured`.
    """
    return Measured(
        place.then(value), kind, experiment, where, place.then(interval), clusters=clusters
    )


@dataclass(frozen=True)
class ThesisRow:
    """A number of the thesis.

    Args:
        place: Where it stands: a table, a figure or a section.
        quantity: What it is.
        thesis: Its value.
        measured: Our measurements; none where no experiment measures it.
        claim: How it is meant.
        unit: The unit of the value.
        said: The words of the thesis, where it gives no digits.
        widest: An interval that is wider decides nothing; None: see `conclusions.WIDEST`.
        slip: The value does not follow from others of the same table.
    """

    place: str
    quantity: str
    thesis: float
    measured: tuple[Measured, ...] = ()
    claim: Claim = Claim.IS
    unit: Unit = Unit.SHARE
    said: str = ""
    widest: float | None = None
    slip: bool = False
