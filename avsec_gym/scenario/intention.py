"""The ego vehicle's driving intention (thesis, section 5.4.1)."""

from __future__ import annotations

from enum import StrEnum


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
