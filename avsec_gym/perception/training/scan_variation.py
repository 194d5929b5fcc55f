"""LiDAR scans that are as true as those there are: mirrored, turned, scaled about the sensor."""

from __future__ import annotations

from typing import Protocol, Self, TypeVar

import numpy as np

from avsec_gym.perception.training.configuration import Augmentation


class VariableScan(Protocol):
    """A scan with its truth, whatever frame its points are in."""

    def mirrored(self) -> Self:
        """Left and right exchanged."""
        ...

    def turned(self, angle: float) -> Self:
        """Turned about the sensor's upright axis by an angle in radians."""
        ...

    def scaled(self, factor: float) -> Self:
        """Everything larger and farther by a factor."""
        ...


_Scan = TypeVar("_Scan", bound=VariableScan)


def varied(
    scan: _Scan, augmentation: Augmentation, largest_turn: float, randomness: np.random.Generator
) -> _Scan:
    """A variation of a scan: mirrored or not, then turned, then scaled.

    Args:
        scan: The scan with its truth.
        augmentation: The share of mirrored ones, and the ratio (`zoom`) of the largest scale to
            the smallest, whose middle is 1.
        largest_turn: The largest turn to either side, radians.
        randomness: The generator that draws it.
    """
    flip, turn, scale = randomness.uniform(size=3)
    scan = scan.mirrored() if flip < augmentation.flip else scan
    turned = scan.turned(float(largest_turn * (2 * turn - 1)))
    return turned.scaled(float(augmentation.zoom ** (scale - 0.5)))
