"""A table of a report, before it is HTML or Markdown; and how numbers are written in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

UNKNOWN = "–"
MINUS = "−"


@dataclass(frozen=True)
class TableCell:
    """One cell.

    Args:
        text: The figure.
        interval: The interval, beside it and smaller.
        thesis: The thesis' figure.
        hint: What is shown when a pointer rests on it.
        key: The value that the column is sorted by; None: its text.
        tone: ``bad``, ``warn`` or nothing.
        words: Whether it holds words, which stand on the left.
    """

    text: str
    interval: str = ""
    thesis: str = ""
    hint: str = ""
    key: float | None = None
    tone: str = ""
    words: bool = False

    @property
    def plain(self) -> str:
        """The text on one line."""
        thesis = f" *{self.thesis}*" if self.thesis else ""
        return f"{self.text} {self.interval}".strip() + thesis


@dataclass(frozen=True)
class Table:
    """Rows of cells below headings.

    Args:
        title: One line on what the table shows.
        columns: Headings, none of them empty; the first ones are names, as many as `names`.
        rows: Rows as wide as `columns`.
        note: How to read it.
        groups: Headings above headings: text and how many columns it spans.
        names: Columns on the left that hold names.
        sortable: Whether readers can sort and filter it.
        filters: Columns that readers pick values of.
        folded: Whether the page shows its title only, until a reader opens it.

    Raises:
        ValueError: A heading is empty: a screen reader would have no name for its column.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[TableCell]]
    note: str = ""
    groups: Sequence[tuple[str, int]] = ()
    names: int = 1
    sortable: bool = False
    filters: Sequence[int] = field(default=())
    folded: bool = False

    def __post_init__(self) -> None:
        if not all(text.strip() for text in self.columns):
            raise ValueError(f"each column has a heading, got {[*self.columns]}: {self.title}")

    @property
    def has_thesis(self) -> bool:
        """Whether figures of the thesis stand in it."""
        return any(cell.thesis for row in self.rows for cell in row)

    @property
    def has_hints(self) -> bool:
        """Whether there is something to be shown under a pointer."""
        return any(cell.hint for row in self.rows for cell in row)


def name(text: str, hint: str = "") -> TableCell:
    """A cell with words."""
    return TableCell(text, hint=hint, words=True)


def figure(
    value: float | None,
    interval: Sequence[float] | None = None,
    thesis: float | None = None,
    *,
    scale: float = 1.0,
    digits: int = 1,
    signed: bool = False,
    hint: str = "",
) -> TableCell:
    """A cell with a number.

    Args:
        value: None: unknown.
        interval: Low and high.
        thesis: The thesis' figure, in the same unit.
        scale: All three are multiplied by it: 100 makes shares percent.
        digits: The number of digits behind the point.
        signed: Whether a plus is written.
        hint: The text for a resting pointer, see `TableCell`.
    """
    if value is None:
        return TableCell(UNKNOWN, thesis=number(thesis, scale, digits), hint=hint)
    return TableCell(
        number(value, scale, digits, signed=signed),
        bounds(interval, scale, digits, signed=signed),
        number(thesis, scale, digits),
        hint,
        scale * value,
    )


def number(
    value: float | None, scale: float = 1.0, digits: int = 1, *, signed: bool = False
) -> str:
    """A number for readers; nothing for None.

    Example:
        >>> number(-0.5), number(0.25, 100, 0, signed=True), number(-0.01)
        ('−0.5', '+25', '0.0')
    """
    if value is None:
        return ""
    rounded = round(scale * value, digits) + 0.0
    text = f"{abs(rounded):,.{digits}f}"
    if rounded < 0:
        return MINUS + text
    return f"+{text}" if signed and rounded > 0 else text


def bounds(
    interval: Sequence[float] | None,
    scale: float = 1.0,
    digits: int = 1,
    *,
    signed: bool = False,
) -> str:
    """An interval for readers; nothing for None.

    Example:
        >>> bounds((-0.5, 1.25))
        '[−0.5, 1.2]'
    """
    if interval is None:
        return ""
    low, high = (number(bound, scale, digits, signed=signed) for bound in interval)
    return f"[{low}, {high}]"


def p_value(p: float | None) -> str:
    """A p-value for readers.

    Example:
        >>> p_value(0.0004), p_value(0.034), p_value(None)
        ('< 0.001', '0.034', '–')
    """
    if p is None:
        return UNKNOWN
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
