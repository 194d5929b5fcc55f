"""Rows become JSON and rows again."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import pytest

from avsec_gym.experiments.json_rows import FLAT, OPTIONAL, as_json, keyed, row_json, row_of
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.scenario.intention import Intention


@dataclass(frozen=True)
class Wheel:
    radius: float
    spokes: Sequence[int] | None


@dataclass(frozen=True)
class Brand:
    name: str
    founded: int


@dataclass(frozen=True)
class Owner:
    owner: str


@dataclass(frozen=True)
class Car:
    """A dataclass of all kinds of fields."""

    wheels: Sequence[Wheel]
    by_place: Mapping[str, Wheel]
    brand: Brand = field(metadata=FLAT)
    owner: Owner | None = field(metadata=FLAT)
    spare: Wheel | None
    at_40: float = field(metadata=keyed("ap_40"))


WHEEL, SPARE = Wheel(0.5, (1, 2)), Wheel(0.25, None)
CAR = Car([WHEEL], {"front": SPARE}, Brand("bmw", 1916), None, None, 0.5)
COLUMNS = {
    "wheels": [{"radius": 0.5, "spokes": [1, 2]}],
    "by_place": {"front": {"radius": 0.25, "spokes": None}},
    "name": "bmw",
    "founded": 1916,
    "spare": None,
    "ap_40": 0.5,
}


def test_a_row_keeps_the_order_of_its_fields() -> None:
    assert row_json(CAR) == COLUMNS
    assert list(row_json(CAR)) == list(COLUMNS)
    assert as_json([{"one": CAR}]) == [{"one": COLUMNS}]


def test_json_becomes_the_row_again() -> None:
    found = row_of(Brand, {"name": "bmw", "founded": 1916, "of another release": 1})
    assert found == Brand("bmw", 1916)
    again = row_of(Car, json.loads(json.dumps(row_json(CAR))))
    assert again.brand == CAR.brand
    assert again.by_place == CAR.by_place
    assert again.owner is None
    assert isinstance(again.wheels[0], Wheel)
    assert row_json(again) == COLUMNS


def test_lists_of_rows_become_rows_again() -> None:
    @dataclass(frozen=True)
    class Garage:
        places: list[Brand]

    garage = Garage([Brand("bmw", 1916)])
    assert row_of(Garage, {"places": [{"name": "bmw", "founded": 1916}]}) == garage


def test_a_value_of_an_enumeration_is_read_back() -> None:
    @dataclass(frozen=True)
    class Turn:
        way: Intention
        last: Intention | None

    assert row_of(Turn, {"way": "left", "last": "right"}) == Turn(Intention.LEFT, Intention.RIGHT)
    assert isinstance(row_of(Turn, {"way": "left"}).way, Intention)
    with pytest.raises(ValueError, match="back"):
        row_of(Turn, {"way": "back"})


def test_rates_without_a_case_are_read_back() -> None:
    @dataclass(frozen=True)
    class Empty:
        rates: SafetyRates

    text = json.dumps(row_json(Empty(SafetyRates.of([]))), allow_nan=False)
    again = row_of(Empty, json.loads(text))
    assert math.isnan(again.rates.mean_path_length)
    assert json.dumps(row_json(again)) == text


def test_a_figure_with_its_interval_may_be_missing() -> None:
    @dataclass(frozen=True)
    class Measured:
        speed: Estimate | None
        other: Estimate | None = field(default=None, metadata=OPTIONAL)

    for measured, columns in (
        (Measured(Estimate(0.5, [0.25, 0.75])), {"speed": 0.5, "speed_interval": [0.25, 0.75]}),
        (Measured(Estimate(None)), {"speed": None, "speed_interval": None}),
        (Measured(None), {"speed": None}),
    ):
        assert row_json(measured) == columns
        assert row_of(Measured, columns) == measured


def test_what_is_missing_is_none_where_it_may_be() -> None:
    without = {key: value for key, value in COLUMNS.items() if key != "spare"}
    assert row_of(Car, without).spare is None
    with pytest.raises(KeyError, match="founded"):
        row_of(Brand, {"name": "bmw"})
    with pytest.raises(TypeError, match="no object"):
        row_of(Car, {**COLUMNS, "by_place": [1]})
