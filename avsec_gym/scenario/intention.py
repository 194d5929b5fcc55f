"""The ego vehicle's driving intention (thesis, section 5.4.1)."""

from __future__ import annotations

from enum import StrEnum
from typing import Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name


class Intention(StrEnum):
    """Where the ego vehicle wants to be 15 metres ahead."""

    LEFT = "left"
    """Changing to the left lane."""
    STRAIGHT = "straight"
    """Keeping the lane."""
    RIGHT = "right"
    """Changing to the right lane."""

    @property
    def lanes_to_the_left(self) -> int:
        """Lateral offset of the goal, counted in lanes."""
        return {Intention.LEFT: 1, Intention.STRAIGHT: 0, Intention.RIGHT: -1}[self]


_ALL = tuple(Intention)


def intentions_named(wanted: Any) -> tuple[Intention, ...]:
    """The one of that name; all of them for None.

    Raises:
        ConfigurationError: There is no such intention.
    """
    if wanted is None:
        return _ALL
    try:
        return (Intention(wanted),)
    except ValueError:
        problem = f"there is no intention {wanted!r}"
        raise ConfigurationError(unknown_name(problem, str(wanted), Intention)) from None
