"""How a LiDAR scan is to be varied, whatever frame its points are in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avsec_gym.perception.training.configuration import Augmentation


class ScanVariation(NamedTuple):
    """Mirrored or not, then turned about the upright axis, then scaled."""

    mirrored: bool
    turn: float
    """The angle by which it is turned, radians."""
    scale: float


def drawn_variation(
    augmentation: Augmentation, largest_turn: float, randomness: np.random.Generator
) -> ScanVariation:
    """A variation of a scan.

    Args:
        augmentation: The share of mirrored ones, and the ratio (`zoom`) of the largest scale to
            the smallest, whose middle is 1.
        largest_turn: The largest turn to either side, radians.
        randomness: The generator that draws it.
    """
    flip, turn, scale = randomness.uniform(size=3)
    return ScanVariation(
        bool(flip < augmentation.flip),
        float(largest_turn * (2 * turn - 1)),
        float(augmentation.zoom ** (scale - 0.5)),
    )
