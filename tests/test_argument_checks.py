"""Checks of single arguments: plain values come back, everything else is refused with a remedy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from avsec_gym.argument_checks import flag, number, number_range, one_of, whole_number
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
    ],
    ids=[f"case-{number}" for number in range(10)],
)
def test_what_fits_comes_back_as_plain_python(checked: Callable[[], Any], expected: Any) -> None:
    value = checked()
    assert value == expected
    assert type(value) is type(expected)


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
    ],
    ids=["whole", "whole-much", "whole-little", "number", "number-much", "range", "flag", "word"],
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
