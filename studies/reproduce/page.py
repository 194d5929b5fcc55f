"""The table of a chapter's rows: the thesis' values beside ours, with conclusions by the rule."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.report.markdown_table import UNKNOWN, markdown_table, number
from studies.reproduce.conclusions import LEAST_CLUSTERS, WIDEST, Decided, conclusion, decision
from studies.reproduce.rows import MOST, NEARLY_ALL, Claim, DataKind, Measured, ThesisRow, Unit
from studies.result_fields import ResultField, bounds_at, is_made, number_at, study_of, value_at
from studies.source_states import SourceState
from studies.study import ROOT

_COLUMNS = ("what", "thesis", "ours", "conclusion", "where", "kind", "sources", "field", "command")
_DIGITS = 2
_KINDS = tuple(kind.value for kind in DataKind)
_SLIP = "not judged: it does not follow from the rest of its table"


@dataclass(frozen=True)
class JudgedRow:
    """A row with what our measurements decide of it.

    Args:
        row: The row.
        ours: One estimate for each measurement; None: not made yet.
        decided: What each decides.
        conclusion: The conclusion on the row.
    """

    row: ThesisRow
    ours: Sequence[Estimate | None]
    decided: Sequence[Decided]
    conclusion: str


def judged(row: ThesisRow, states: Mapping[str, SourceState], root: Path = ROOT) -> JudgedRow:
    """Hold a row against the results.

    Args:
        row: The row.
        states: Today's state of studies.
        root: Root of the checkout.

    Raises:
        DataError: A result that was made has not the field that the row names.
    """
    widest = WIDEST[row.unit] if row.widest is None else row.widest
    ours = [_estimate(each, root) for each in row.measured]
    decided = [
        Decided(
            decision(row.claim, row.thesis, estimate, widest, _clusters(each.clusters, root)),
            each.kind,
            each.experiment,
            each.where,
            states[study_of(each.value.result).name].word,
        )
        for each, estimate in zip(row.measured, ours, strict=True)
    ]
    return JudgedRow(row, ours, decided, _SLIP if row.slip else conclusion(decided))


def rule_lines() -> list[str]:
    """The rule of conclusions, in words and with its constants."""
    points, apart = 100 * WIDEST[Unit.SHARE], WIDEST[Unit.NUMBER]
    return [
        "Conclusions follow a rule (`studies/reproduce/conclusions.py`); none is typed by hand."
        " A value of the thesis beyond the 95 % interval of ours is contradicted, unless the thesis"
        " bounds it from one side and the interval lies on that side: then it is confirmed. A value"
        f" within the interval is confirmed if the interval is no wider than {points:g} points"
        f" (correlations and other numbers: {apart:g}), and open otherwise. Open, too, is what has"
        f" no interval, or fewer than {LEAST_CLUSTERS} frames, drives or scenes. Of several kinds"
        f" of data the weightiest that decides anything decides alone: {', '.join(_KINDS)}. Words"
        f' are read as numbers: "most" as {100 * MOST:g} %, "nearly all" and "very close to 100 %"'
        f" as {100 * NEARLY_ALL:g} %. Stale: the sources of the result have changed since."
    ]


def summary_lines(rows: Sequence[JudgedRow]) -> list[str]:
    """How many rows are confirmed, confirmed in part, contradicted and open."""
    counts = Counter(_first_words(each.conclusion) for each in rows)
    listed = ", ".join(f"{count} {word}" for word, count in sorted(counts.items()))
    return [f"{len(rows)} values: {listed}."]


def table_lines(rows: Sequence[JudgedRow], states: Mapping[str, SourceState]) -> list[str]:
    """The tables, one for each place in the thesis.

    Args:
        rows: The judged rows of a chapter, in order.
        states: Today's state of studies.
    """
    lines: list[str] = []
    for place in dict.fromkeys(each.row.place for each in rows):
        here = [each for each in rows if each.row.place == place]
        cells = [line for each in here for line in _cells(each, states)]
        lines += [f"### {place}", "", *markdown_table(_COLUMNS, cells), ""]
    return lines[:-1]


def _cells(judged_row: JudgedRow, states: Mapping[str, SourceState]) -> list[list[str]]:
    """A line for each measurement; the first has the thesis' value and the conclusion."""
    row = judged_row.row
    head = [row.quantity, _thesis(row)]
    if not row.measured:
        return [[*head, UNKNOWN, judged_row.conclusion, *[UNKNOWN] * 5]]
    lines: list[list[str]] = []
    for each, estimate in zip(row.measured, judged_row.ours, strict=True):
        first = not lines
        study = study_of(each.value.result)
        lines.append(
            [
                *(head if first else ["", ""]),
                _ours(estimate, row.unit),
                judged_row.conclusion if first else "",
                each.where or UNKNOWN,
                each.kind.value,
                states[study.name].word,
                f"`{each.value}`",
                f"`{study.command}`",
            ]
        )
    return lines


def _thesis(row: ThesisRow) -> str:
    value = number(row.thesis * row.unit.shown, _DIGITS) + row.unit.sign
    bound = "" if row.claim is Claim.IS else f"{row.claim.value} "
    return f"{bound}{value}" + (f' ("{row.said}")' if row.said else "")


def _ours(estimate: Estimate | None, unit: Unit) -> str:
    if estimate is None or estimate.value is None:
        return UNKNOWN
    value = number(estimate.value * unit.shown, _DIGITS) + unit.sign
    if estimate.interval is None:
        return value
    low, high = (number(bound * unit.shown, _DIGITS) for bound in estimate.interval)
    return f"{value} [{low}, {high}]"


def _estimate(measured: Measured, root: Path) -> Estimate | None:
    """What a result holds; None where it has not been made yet."""
    if not is_made(measured.value.result, root):
        return None
    value = number_at(measured.value, root)
    if value is None:
        return None
    if measured.interval is not None:
        return Estimate(value, bounds_at(measured.interval, root))
    if measured.cases is not None:
        cases = number_at(measured.cases, root) or 0
        share = Share.of_counts(round(value * cases), int(cases))
        return Estimate(value, share.interval)
    return Estimate(value)


def _clusters(place: ResultField | None, root: Path) -> int | None:
    """The number of clusters, or the length of the list of them."""
    if place is None or not is_made(place.result, root):
        return None
    found = value_at(place, root)
    return len(found) if isinstance(found, (list, dict)) else int(number_at(place, root) or 0)


def _first_words(conclusion_of_row: str) -> str:
    """``confirmed``, ``confirmed in part``, ``contradicted``, ``open`` or ``not judged``."""
    if conclusion_of_row.startswith("confirmed where"):
        return "confirmed in part"
    return next(
        word
        for word in ("confirmed", "contradicted", "open", "not judged")
        if conclusion_of_row.startswith(word)
    )
