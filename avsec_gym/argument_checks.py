"""Checks of single arguments, for whatever takes them from users.

Each function returns the value as plain Python, or raises one `ConfigurationError` that states what
was expected, what came, and a value that would do.  numpy's numbers count as numbers; True and
False do not, and texts never do.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name

_LONGEST = 100
"""Letters of a wrong value that a message shows."""


def whole_number(name: str, value: Any, least: int, most: int | None = None) -> int:
    """A whole number from a least to a most one.

    Args:
        name: What the user calls the argument.
        value: What the user gave.
        least: The smallest number that is allowed.
        most: The largest one; None: any.

    Raises:
        ConfigurationError: It is something else, such as 2.0.

    Example:
        >>> whole_number("queries", 5, 1)
        5
    """
    if _is(value, Integral) and least <= value and (most is None or value <= most):
        return int(value)
    limits = f"of {least:,} or more" if most is None else f"from {least:,} to {most:,}"
    near = round(_nearest(value, least, math.inf if most is None else most))
    raise _refused(name, f"a whole number {limits}", value, str(near))


def number(name: str, value: Any, low: float, high: float) -> float:
    """A number in a range; errors as of `whole_number`.

    Args:
        name: What the user calls the argument.
        value: What the user gave.
        low: The smallest number that is allowed.
        high: The largest one.

    Example:
        >>> number("price", 1, 0.0, 1.0)
        1.0
    """
    if _is(value, Real) and low <= value <= high:
        return float(value)
    expected = f"a number from {low:g} to {high:g}"
    raise _refused(name, expected, value, f"{_nearest(value, low, high):g}")


def number_range(
    name: str, value: Any, low: float, high: float, *, may_be_one: bool = False
) -> tuple[float, float]:
    """A smallest and a largest number; errors as of `whole_number`.

    Args:
        name: What the user calls the argument.
        value: What the user gave: a tuple, a list or an array of two numbers.
        low: The smallest number that is allowed.
        high: The largest one.
        may_be_one: Whether the two may be equal.

    Example:
        >>> number_range("radii", [37.5, 375], 1.0, 1000.0)
        (37.5, 375.0)
    """
    ends = value.tolist() if isinstance(value, np.ndarray) else value
    pair = isinstance(ends, list | tuple) and len(ends) == 2
    if pair and all(_is(end, Real) and low <= end <= high for end in ends):
        first, last = float(ends[0]), float(ends[1])
        if first < last or (may_be_one and first == last):
            return first, last
    order = "the smaller one first" + (", or both equal" if may_be_one else "")
    expected = f"two numbers from {low:g} to {high:g}, {order}"
    raise _refused(name, expected, value, f"({low:g}, {high:g})")


def flag(name: str, value: Any) -> bool:
    """True or False; errors as of `whole_number`, also for 0 and 1.

    Args:
        name: What the user calls the argument.
        value: What the user gave.
    """
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise _refused(name, "True or False", value, "True")


def one_of(name: str, value: Any, known: Iterable[str]) -> str:
    """One of some words.

    Args:
        name: What the user calls the argument.
        value: What the user gave.
        known: The words.

    Raises:
        ConfigurationError: It is none of them; the message asks which one may have been meant.
    """
    known = list(known)
    if isinstance(value, str) and value in known:
        return value
    raise ConfigurationError(unknown_name(f"there is no {name} {shown(value)}", str(value), known))


def shown(value: Any) -> str:
    """A value as a message can show it."""
    text = repr(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _is(value: Any, kind: type) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool)


def _nearest(value: Any, low: float, high: float) -> float:
    """The allowed number that is nearest; the smallest one where no finite number was given."""
    finite = _is(value, Real) and -math.inf < value < math.inf
    return max(low, min(high, value)) if finite else low


def _refused(name: str, expected: str, value: Any, example: str) -> ConfigurationError:
    return ConfigurationError(
        f"{name} takes {expected}, got {shown(value)}: for instance, give {name}={example}"
    )
