"""Checks of single arguments: plain values come back, everything else is refused with a remedy."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.argument_checks import (
    camera_number,
    flag,
    instance_of,
    instance_or_none,
    label,
    number,
    number_or_range,
    number_range,
    numbers,
    one_of,
    place,
    seed_number,
    whole_number,
)
from avsec_gym.errors import ConfigurationError


@pytest.mark.parametrize(
    ("checked", "expected"),
    [
        (lambda: whole_number("n", 3, 1), 3),
        (lambda: whole_number("n", np.int64(1), 1, 1), 1),
        (lambda: whole_number("n", 10**30, 1), 10**30),
        (lambda: number("x", 1, 0.0, 1.0), 1.0),
        (lambda: number("x", np.float32(0.5), 0.0, 1.0), 0.5),
        (lambda: number_range("r", [1, 2], 1.0, 2.0), (1.0, 2.0)),
        (lambda: number_range("r", np.array([1, 2]), 1.0, 2.0), (1.0, 2.0)),
        (lambda: number_range("r", (2, 2), 1.0, 2.0, may_be_one=True), (2.0, 2.0)),
        (lambda: flag("f", np.bool_(False)), False),
        (lambda: one_of("w", "b", ("a", "b")), "b"),
        (lambda: number_or_range("r", np.float32(0.5), 0.0, 1.0), 0.5),
        (lambda: number_or_range("r", np.array([1, 1]), 0.0, 1.0), (1.0, 1.0)),
        (lambda: numbers("c", [1, np.float32(0.5), 0], 3, 0.0, 1.0), (1.0, 0.5, 0.0)),
        (lambda: camera_number("c", np.int64(2)), 2),
        (lambda: seed_number("s", 2**63 - 1), 2**63 - 1),
        (lambda: label("n", "\u00e9 1"), "\u00e9 1"),
        (lambda: place("p", "a/b"), Path("a/b")),
        (lambda: instance_of("i", 3, int), 3),
        (lambda: instance_or_none("i", None, int), None),
    ],
    ids=[f"case-{number}" for number in range(19)],
)
def test_what_fits_comes_back_as_plain_python(checked: Callable[[], Any], expected: Any) -> None:
    value = checked()
    assert value == expected
    assert type(value) is type(expected)
    if isinstance(value, tuple):
        assert {type(each) for each in value} == {float}


@pytest.mark.parametrize(
    ("check", "wrong", "nearest"),
    [
        (lambda v: whole_number("n", v, 2, 9), (None, "3", 3.0, True, [3], 1j), "n=[23]$"),
        (lambda v: whole_number("n", v, 2, 9), (10, 10**30), "n=9$"),
        (lambda v: whole_number("n", v, 2), (1, -5, float("inf"), float("nan")), "n=2$"),
        (lambda v: number("x", v, 0.0, 1.0), (None, "0.5", True, -1, [0.5], float("nan")), "x=0$"),
        (lambda v: number("x", v, 0.0, 1.0), (2, 1e9), "x=1$"),
        (
            lambda v: number_range("r", v, 1.0, 9.0),
            (3, None, "ab", (2, 1), (1, 1), (1,), (0, 2), (1, 10), (1, "b"), (1, [2]), {1: 2}),
            r"r=\(1, 9\)$",
        ),
        (lambda v: flag("f", v), (None, 0, 1, "no", []), "f=True$"),
        (lambda v: one_of("w", v, ("ab", "cd")), (None, {}, "ba", np.zeros(2)), "Known: ab, cd$"),
        (
            lambda v: number_or_range("r", v, 1.0, 9.0),
            (None, "a", 0.5, True, (2, 1), (1,), (1, "b"), np.zeros((2, 2)), np.array(5)),
            r"^r takes (a|two) number",
        ),
        (
            lambda v: numbers("c", v, 2, 0.0, 1.0),
            (None, 1, "ab", (1,), (1, 2), (1, None), (1, True), np.zeros((2, 2)), {1: 0, 0: 1}),
            r"c=\(1, 1\)$",
        ),
        (lambda v: camera_number("c", v), (None, True, -1, 101, 2.0, "2"), "c=[0-9]+$"),
        (lambda v: seed_number("s", v), (None, True, -1, 2**63, 0.5, [1]), "s=[0-9]+$"),
        (lambda v: label("n", v), (None, 1, "", "\0", "a\n", "x" * 101, b"a"), "n='mine'$"),
        (lambda v: place("p", v), (None, 1, b"a", ["a"], {}), "^p takes the name of a file"),
        (lambda v: instance_of("i", v, Path), (None, "a", 0, Path), "^i takes a Path, got"),
        (lambda v: instance_or_none("i", v, Path), ("a", 0, False), "^i takes a Path, got"),
    ],
    ids=[
        *("whole", "whole-much", "whole-little", "number", "number-much", "range", "flag", "word"),
        *(
            "number-or-range",
            "numbers",
            "camera",
            "seed",
            "label",
            "place",
            "instance",
            "instance?",
        ),
    ],
)
def test_what_does_not_fit_is_refused_with_a_value_that_does(
    check: Callable[[Any], Any], wrong: tuple[Any, ...], nearest: str
) -> None:
    for value in wrong:
        with pytest.raises(ConfigurationError, match=nearest):
            check(value)


def test_a_message_stays_short() -> None:
    with pytest.raises(ConfigurationError) as raised:
        flag("f", "x" * 10_000)
    assert len(str(raised.value)) < 200
