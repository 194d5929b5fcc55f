"""`Regions`: upright boxes in the world that connected vehicles share, where objects may be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats


@dataclass(frozen=True, eq=False)
class Regions:
    """Upright boxes in the world frame: x and y along the ground, z up.

    Args:
        centre: Centres of their bottoms, metres, shape (N, 3).
        size: Lengths, widths, heights, metres, shape (N, 3).
        heading: The regions' headings, radians from x towards y, shape (N,).

    Raises:
        DataError: Shapes differ, a number is not finite, or a size is not positive.

    Example:
        >>> len(Regions.empty())
        0
    """

    centre: Floats
    size: Floats
    heading: Floats

    def __post_init__(self) -> None:
        count = len(self.heading)
        if self.centre.shape != (count, 3) or self.size.shape != (count, 3):
            raise DataError(
                f"regions have centres and sizes of shape ({count}, 3), not"
                f" {self.centre.shape} and {self.size.shape}"
            )
        every = np.concatenate([self.centre, self.size, self.heading[:, None]], axis=1)
        if not np.isfinite(every).all() or (self.size <= 0).any():
            raise DataError("regions have finite centres and headings, and positive sizes")

    def __len__(self) -> int:
        return len(self.heading)

    def __getitem__(self, chosen: slice | NDArray[Any]) -> Self:
        """Some of them, by a slice, a mask or an array of indices."""
        return type(self)(self.centre[chosen], self.size[chosen], self.heading[chosen])

    def grown(self, sides: float, top: float = 0.0) -> Self:
        """The regions with margins, in metres, at the four sides and at the top."""
        margins = np.array([2 * sides, 2 * sides, top])
        return type(self)(self.centre, self.size + margins, self.heading)

    def local(self, index: int, points: Floats) -> Floats:
        """Points of the world in a region's frame: its bottom centre, x along its heading.

        Args:
            index: The region.
            points: Points of the world, shape (M, 3).

        Returns:
            Shape (M, 3).
        """
        cos, sin = np.cos(self.heading[index]), np.sin(self.heading[index])
        x, y, z = (points - self.centre[index]).T
        return np.stack([cos * x + sin * y, cos * y - sin * x, z], axis=1)

    def contains(self, index: int, points: Floats) -> NDArray[np.bool_]:
        """Whether points of the world lie in a region; shape (M,) of bool."""
        inside: NDArray[np.bool_] = (
            np.abs(self.local(index, points) - [0, 0, self.size[index, 2] / 2])
            <= self.size[index] / 2
        ).all(axis=1)
        return inside

    @classmethod
    def empty(cls) -> Self:
        """No regions."""
        return cls(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
