"""Rows on made-up results: the value of the thesis, ours, and the conclusion."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from studies.reproduce.page import judged, summary_lines, table_lines
from studies.reproduce.rows import Claim, DataKind, Measured, ThesisRow, Unit, measured
from studies.result_fields import field, row
from studies.source_states import SourceState
from studies.study import RESULTS

STATES = {"believed": SourceState(True, ""), "chapter4": SourceState(None, "")}
RATES = field("believed", "rates")


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / RESULTS).mkdir(parents=True)
    rates = [
        {"way": "left", "rate": 0.5, "interval": [0.48, 0.53], "of": 3},
        {"way": "right", "rate": 0.9, "interval": [0.88, 0.92], "of": 900},
    ]
    (tmp_path / RESULTS / "believed.json").write_text(json.dumps({"rates": rates, "drives": [1]}))
    return tmp_path


def way(name: str) -> Measured:
    return measured(RATES.then(row(way=name)), DataKind.PROCEDURAL, "believed", name)


def test_the_lines_of_a_row(root: Path) -> None:
    thesis = ThesisRow(
        "Table 1", "cases", 0.9, (way("left"), way("right")), Claim.AT_LEAST, said="nine of ten"
    )
    later = ThesisRow(
        "Figure 2", "later", 7.0,
        (measured(field("chapter4", "a"), DataKind.REAL, "chapter4", value="b"),), unit=Unit.NUMBER,
    )  # fmt: skip
    rows = [
        judged(each, STATES, root) for each in (thesis, later, ThesisRow("Figure 2", "no", 1.0))
    ]
    lines = table_lines(rows, STATES)
    assert lines[0] == "### Table 1"
    assert lines[4] == (
        '| cases | at least 90.00 % ("nine of ten") | 50.00 % [48.00, 53.00] |'
        " confirmed where right; contradicted where left, by `believed` (procedural, stale) |"
        " left | procedural | stale |"
        " `believed.json: rates[way=left].rate` | `python -m studies.believed` |"
    )
    assert lines[5].startswith("|  |  | 90.00 % [88.00, 92.00] |  | right |")
    assert lines[7] == "### Figure 2"
    assert lines[11] == (
        "| later | 7.00 | – | open (not measured yet) | – | real | not made yet |"
        " `chapter4.json: a.b` | `python -m studies.chapter4` |"
    )
    assert lines[12] == "| no | 100.00 % | – | open (not measured yet) | – | – | – | – | – |"
    assert summary_lines(rows) == ["3 values: 1 confirmed in part, 2 open."]


def test_an_interval_is_made_of_the_number_of_cases(root: Path) -> None:
    right = RATES.then(row(way="right"))
    of_cases = Measured(right.then("rate"), DataKind.REAL, "a", cases=right.then("of"))
    found = judged(ThesisRow("Table 1", "cases", 0.9, (of_cases,)), STATES, root).ours[0]
    assert found is not None
    assert found.interval is not None
    # Wilson's, of 810 of 900: centre (p + z^2 / 2 n) / (1 + z^2 / n).
    assert found.interval == pytest.approx((0.8786, 0.9179), abs=2e-4)


def test_few_clusters_and_slips_are_not_judged(root: Path) -> None:
    few = measured(
        RATES.then(row(way="left")), DataKind.REAL, "a", clusters=field("believed", "drives")
    )
    assert (
        judged(ThesisRow("T", "q", 0.9, (few,)), STATES, root).conclusion == "open (too few cases)"
    )
    slip = judged(ThesisRow("T", "q", 0.9, (way("left"),), slip=True), STATES, root)
    assert slip.conclusion.startswith("not judged")
    assert summary_lines([slip]) == ["1 values: 1 not judged."]


def test_a_result_without_the_field_is_an_error(root: Path) -> None:
    with pytest.raises(DataError, match=r"believed\.json: rates\[way=up\]\.rate"):
        judged(ThesisRow("T", "q", 0.9, (way("up"),)), STATES, root)
