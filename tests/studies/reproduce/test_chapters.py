"""Every row leads to a field of a result, or to a study that has not been made yet."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Any

import pytest

from avsec_gym.experiments.chapter3.thesis import DETECTION, IDENTIFICATION, OBJECT_LEVEL
from avsec_gym.experiments.chapter4.settings import EXACT, USUAL
from avsec_gym.experiments.thesis import INTENTIONS, PRECISION, SAFETY
from avsec_gym.runs.catalogue import EXPERIMENTS
from studies.catalogue import STUDIES
from studies.reproduce.chapter3 import chapter3_rows
from studies.reproduce.chapter4 import chapter4_rows
from studies.reproduce.chapter5 import chapter5_rows
from studies.reproduce.rows import Measured, ThesisRow, Unit
from studies.result_fields import OnlyRow, bounds_at, is_made, number_at, study_of, value_at
from studies.study import RESULTS, ROOT

CHAPTERS: tuple[Callable[[], list[ThesisRow]], ...] = (chapter3_rows, chapter4_rows, chapter5_rows)
ROWS = [row for chapter in CHAPTERS for row in chapter()]


def measurements() -> Iterator[Measured]:
    return (each for row in ROWS for each in row.measured)


def test_every_field_is_there_or_its_study_is_still_to_be_made() -> None:
    for each in measurements():
        study = study_of(each.value.result)
        if not is_made(each.value.result):
            assert study.name == "chapter4", each.value
            continue
        number_at(each.value)
        if each.interval is not None:
            bounds = bounds_at(each.interval)
            assert bounds is None or bounds[0] <= bounds[1]
        for place in (each.cases, each.clusters):
            assert place is None or value_at(place), place


def test_an_interval_is_of_its_value() -> None:
    """It stands in the same row of the result, and holds the value, but for bootstraps of AP."""
    for each in measurements():
        if each.interval is None or not is_made(each.value.result):
            continue
        mine = [step for step in each.value.steps if isinstance(step, OnlyRow)]
        assert mine == [step for step in each.interval.steps if isinstance(step, OnlyRow)]
        value, bounds = number_at(each.value), bounds_at(each.interval)
        if value is not None and bounds is not None and "ap11" not in each.value.steps:
            assert bounds[0] - 1e-9 <= value <= bounds[1] + 1e-9, each.value


def test_no_number_of_the_typed_tables_is_left_out() -> None:
    places = Counter(row.place for row in ROWS)
    assert places["Table 3.1"] == len(DETECTION) + len(OBJECT_LEVEL) == 14
    assert places["Table 3.2"] == 5 * len(IDENTIFICATION) == 25
    unattacked, first = places["Tables 5.1, 5.2, 5.4"], places["Table 5.1"]
    assert unattacked + first + places["Table 5.2"] + places["Table 5.4"] == 3 * len(SAFETY)
    # Two detectors, four steps, three intentions, three rates.
    assert first == places["Table 5.2"] == 72
    assert (unattacked, places["Table 5.4"]) == (18, 36)
    assert places["Table 5.3"] == 3 * (len(PRECISION) - 1) == 30
    assert places["Table 5.5"] == 3 * len(INTENTIONS) == 12
    assert (places["Table 5.6"], places["Table 5.7"]) == (6, 21)
    figures = {f"Figure 3.{number}" for number in range(5, 13)} | {"Figure 4a", "Figure 4b"}
    assert figures | {f"Figure 5.{number}" for number in (3, 6, 7, 8)} <= set(places)


def test_rows_are_told_apart() -> None:
    names = Counter((row.place, row.quantity) for row in ROWS)
    assert [name for name, count in names.items() if count > 1] == []
    for row in ROWS:
        places = [(each.kind, each.where) for each in row.measured]
        assert len(places) == len(set(places)), row.quantity
        if len(places) > 1:
            by_kind = Counter(each.kind for each in row.measured)
            assert all(each.where for each in row.measured if by_kind[each.kind] > 1)


def test_values_are_in_their_units() -> None:
    for row in ROWS:
        assert row.unit is not Unit.SHARE or 0 <= row.thesis <= 1, row.quantity
        assert row.unit is not Unit.PERCENT or row.thesis == 0 or row.thesis >= 1, row.quantity


def test_experiments_are_known() -> None:
    modules = {"real_frames", "driving_safety", "classifiers", "connected_viewpoints"}
    assert {each.experiment for each in measurements()} <= {*EXPERIMENTS, *modules}
    assert modules - {"real_frames"} <= set(STUDIES)


def test_figures_of_chapter_4_are_columns_of_its_summary() -> None:
    """Its result is still to be made: the names are held to those of the dataclasses."""
    from avsec_gym.experiments.chapter4.detection_rates import DetectionRate
    from avsec_gym.experiments.chapter4.distance_distributions import DistanceDistribution
    from avsec_gym.experiments.chapter4.settings import CURVE_RATES
    from avsec_gym.experiments.chapter4.summary import ConnectedSummary

    for each in (each for row in chapter4_rows() for each in row.measured):
        if each.value.result != "chapter4":
            continue
        first, table, columns, *rest = each.value.steps
        assert (first, isinstance(columns, OnlyRow)) == ("connected", True)
        assert table in ConnectedSummary.__annotations__
        assert isinstance(columns, OnlyRow)
        found: Mapping[str, object] = dict(columns.columns)
        assert found["condition"] in {EXACT.name, USUAL.name}
        kind = DistanceDistribution if table == "distances" else DetectionRate
        assert {*found, rest[0]} <= set(kind.__annotations__)
        assert found.get("rate", 0.1) in CURVE_RATES
        assert rest[-1] == "rate"


@pytest.mark.parametrize("chapter", [3, 4, 5])
def test_a_page_has_a_line_for_every_measurement(chapter: int) -> None:
    page = (ROOT / f"docs/reproduce_chapter{chapter}.md").read_text()
    rows = CHAPTERS[chapter - 3]()
    lines = [line for line in page.splitlines() if re.search(r"`\w+\.json: ", line)]
    assert len(lines) == sum(len(row.measured) for row in rows)
    for row in rows:
        assert f"\n| {row.quantity} |" in page
    assert f"{len(rows)} values: " in page


@cache
def content(result: str) -> Any:
    return json.loads((ROOT / RESULTS / f"{result}.json").read_text())


def named_value(words: str) -> float | None:
    """The value that a page's words name, read with nothing of the package."""
    result, _, way = words.partition(".json: ")
    value = content(result)
    for key, selector in re.findall(r"([\w+-]+)((?:\[.*?\])?)", way):
        value = value[int(key)] if isinstance(value, list) else value[key]
        if selector:
            wanted = dict(re.findall(r"(\w+)=(.*?)(?=, \w+=|\])", selector))
            [value] = [row for row in value if all(str(row[k]) == v for k, v in wanted.items())]
    return None if value is None else float(value)


@pytest.mark.parametrize("chapter", [3, 4, 5])
def test_every_figure_of_ours_is_found_in_the_json_that_its_line_names(chapter: int) -> None:
    page = (ROOT / f"docs/reproduce_chapter{chapter}.md").read_text()
    line = r"^\|(?:[^|]*\|){2} ([^|]*) \|(?:[^|]*\|){4} `(\w+\.json: .*?)` \|"
    lines = re.findall(line, page, re.MULTILINE)
    assert len(lines) > 4
    for ours, words in lines:
        if ours == "–":
            assert not (ROOT / RESULTS / f"{words.partition('.')[0]}.json").exists() or (
                named_value(words) is None
            )
            continue
        value = named_value(words)
        assert value is not None
        shown = float(ours.partition(" ")[0].replace(",", ""))
        assert any(abs(shown - scale * value) <= 0.00501 for scale in (1, 100)), (ours, words)
