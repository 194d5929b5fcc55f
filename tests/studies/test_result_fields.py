"""A field leads to one value of a result, or says that it does not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from studies.catalogue import STUDIES
from studies.result_fields import (
    ResultField,
    bounds_at,
    field,
    is_made,
    number_at,
    row,
    study_of,
    value_at,
)
from studies.study import RESULTS

RATES = [
    {"way": "left", "r": 0.01, "of": None, "rate": 0.5, "interval": [0.25, 0.75]},
    {"way": "left", "r": 0.02, "of": None, "rate": 1, "interval": None},
    {"way": "right", "r": 0.01, "of": 3, "rate": None, "interval": [0.5]},
]


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / RESULTS).mkdir(parents=True)
    (tmp_path / RESULTS / "new.json").write_text(json.dumps({"a": {"rates": RATES, "on": True}}))
    return tmp_path


def test_a_row_is_found_by_its_columns(root: Path) -> None:
    place = field("new", "a", "rates", row(way="left", r=0.01))
    assert number_at(place.then("rate"), root) == 0.5
    assert bounds_at(place.then("interval"), root) == (0.25, 0.75)
    assert number_at(place.then("interval", 1), root) == 0.75
    assert value_at(field("new", "a", "rates", row(of=3)), root) == RATES[2]
    assert number_at(field("new", "a", "rates", 2, "rate"), root) is None
    assert bounds_at(field("new", "a", "rates", 1, "interval"), root) is None
    assert str(place.then("rate")) == "new.json: a.rates[way=left, r=0.01].rate"


@pytest.mark.parametrize(
    "place",
    [
        field("new", "b"),
        field("new", "a", "rates", 3),
        field("new", "a", "rates", "rate"),
        field("new", "a", "rates", row(way="up"), "rate"),
        field("new", "a", "rates", row(way="left"), "rate"),  # There are two of them.
        field("new", "a", "rates", row(speed=None), "rate"),
        field("new", "a", "on"),
        field("new", "a", "rates"),
        field("other", "a"),
    ],
    ids=str,
)
def test_what_is_no_number_is_an_error_that_names_it(place: ResultField, root: Path) -> None:
    with pytest.raises(DataError, match=rf"{place.result}\.json"):
        number_at(place, root)


def test_an_interval_has_two_ends(root: Path) -> None:
    with pytest.raises(DataError, match="not an interval"):
        bounds_at(field("new", "a", "rates", 2, "interval"), root)


def test_a_result_that_was_made_anew_is_read_anew(root: Path) -> None:
    place = field("new", "a", "rates", 0, "rate")
    assert number_at(place, root) == 0.5
    file = root / RESULTS / "new.json"
    file.write_text('{"a": {"rates": [{"rate": 0.125}]}}')
    assert number_at(place, root) == 0.125
    assert is_made("new", root)
    assert not is_made("other", root)


def test_a_result_belongs_to_the_study_that_writes_it() -> None:
    assert study_of("chapter5_errors") is STUDIES["chapter5"]
    with pytest.raises(DataError, match="No study writes"):
        study_of("nothing")
