"""Checks of single arguments, for whatever takes them from users.

Each function returns the value as plain Python, or raises one `ConfigurationError` that states what
was expected, what came, and a value that would do.  numpy's numbers count as numbers; True and
False do not, and texts never do.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name

LARGEST_SEED = 2**63 - 1
"""What every generator of random numbers takes."""
_LONGEST = 100
"""Letters of a wrong value that a message shows, and of a name that is given to something."""
_MOST_CAMERAS = 100
_MOST_THREADS = 1024
_MOST_RESAMPLES = 100_000
_Kind = TypeVar("_Kind")
_Number = TypeVar("_Number", bound=np.generic)


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


def number_or_range(name: str, value: Any, low: float, high: float) -> float | tuple[float, float]:
    """A number, or two between which one is drawn; errors as of `whole_number`.

    Args:
        name: What the user calls the argument.
        value: What the user gave: a number, or what `number_range` takes; the two may be equal.
        low: The smallest number that is allowed.
        high: The largest one.

    Example:
        >>> number_or_range("radius", 40, 1.0, 1000.0)
        40.0
    """
    if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
        return number_range(name, value, low, high, may_be_one=True)
    return number(name, value, low, high)


def numbers(name: str, value: Any, count: int, low: float, high: float) -> tuple[float, ...]:
    """So many numbers in a range; errors as of `whole_number`.

    Args:
        name: What the user calls the argument.
        value: What the user gave: a tuple, a list or an array.
        count: How many there are.
        low: The smallest number that is allowed.
        high: The largest one.

    Example:
        >>> numbers("colour", [1, 0.5, 0], 3, 0.0, 1.0)
        (1.0, 0.5, 0.0)
    """
    given = value.tolist() if isinstance(value, np.ndarray) else value
    several = isinstance(given, list | tuple) and len(given) == count
    if several and all(_is(each, Real) and low <= each <= high for each in given):
        return tuple(float(each) for each in given)
    expected = f"{count} numbers from {low:g} to {high:g}"
    raise _refused(name, expected, value, f"({', '.join(count * [f'{high:g}'])})")


def camera_number(name: str, value: Any) -> int:
    """The number of a camera, from 0 on; errors as of `whole_number`.

    Args:
        name: What the user calls the argument.
        value: What the user gave.
    """
    return whole_number(name, value, 0, _MOST_CAMERAS)


def thread_number(name: str, value: Any) -> int:
    """How many threads, 1 to 1,024: more end the process; errors as of `whole_number`.

    Args:
        name: What the user calls the argument.
        value: What the user gave.
    """
    return whole_number(name, value, 1, _MOST_THREADS)


def resample_number(name: str, value: Any) -> int:
    """How many bootstrap samples, 0 to 100,000, which memory holds; errors as of `whole_number`.

    Args:
        name: What the user calls the argument.
        value: What the user gave.
    """
    return whole_number(name, value, 0, _MOST_RESAMPLES)


def seed_number(name: str, value: Any) -> int:
    """A seed; errors as of `whole_number`.

    Args:
        name: What the user calls the argument.
        value: What the user gave.
    """
    return whole_number(name, value, 0, LARGEST_SEED)


def label(name: str, value: Any) -> str:
    """A name that something has in results, which are lines and files.

    Args:
        name: What the user calls the argument.
        value: What the user gave.

    Raises:
        ConfigurationError: It is no text of 1 to 100 letters that can be printed.
    """
    if isinstance(value, str) and 0 < len(value) <= _LONGEST and value.isprintable():
        return value
    expected = f"a text of 1 to {_LONGEST} printable letters"
    raise _refused(name, expected, value, "'mine'")


def place(name: str, value: Any) -> Path:
    """A file or a folder, there or not.

    Args:
        name: What the user calls the argument.
        value: What the user gave.

    Raises:
        ConfigurationError: It is no text and no path.
    """
    if isinstance(value, str | Path):
        return Path(value)
    raise ConfigurationError(f"{name} takes the name of a file or folder, got {shown(value)}")


def instance_of(name: str, value: Any, kind: type[_Kind]) -> _Kind:
    """An object of a class.

    Args:
        name: What the user calls the argument.
        value: What the user gave.
        kind: The class.

    Raises:
        ConfigurationError: It is something else.
    """
    if isinstance(value, kind):
        return value
    raise ConfigurationError(f"{name} takes a {kind.__name__}, got {shown(value)}")


def instance_or_none(name: str, value: Any, kind: type[_Kind]) -> _Kind | None:
    """An object of a class, or None for the usual one; errors as of `instance_of`.

    Args:
        name: What the user calls the argument.
        value: What the user gave.
        kind: The class.
    """
    return None if value is None else instance_of(name, value, kind)


def keep_checked(part: object, checked: Mapping[str, Any]) -> None:
    """Give a frozen dataclass its arguments as they were checked, in its ``__post_init__``.

    Args:
        part: The dataclass' object.
        checked: The values by the names of its fields.
    """
    for name, value in checked.items():
        object.__setattr__(part, name, value)


def keep_read_only(part: object, values: Mapping[str, Any]) -> None:
    """Give a frozen dataclass its values, of which arrays are copied and cannot be written into.

    What was checked stays what it is: neither the part's arrays nor the caller's own can change it
    later.  A part calls it in its ``__post_init__``, and in its ``__setstate__``, since a copy that
    comes out of a pickle could be written into again.

    Args:
        part: The dataclass' object.
        values: The values by the names of its fields.
    """
    for name, value in values.items():
        kept = read_only(value.copy()) if isinstance(value, np.ndarray) else value
        object.__setattr__(part, name, kept)


def read_only(array: NDArray[_Number]) -> NDArray[_Number]:
    """The array, which cannot be written into any more.

    Args:
        array: An array that has no other owner.
    """
    array.flags.writeable = False
    return array


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
