"""The numbers of a seed, to which an attack adds its own."""

from __future__ import annotations

import numpy as np

from avsec_gym.attacks.attack import Seed


def seed_numbers(seed: Seed) -> list[int]:
    """The numbers that a seed consists of: one or several, Python's or NumPy's.

    Args:
        seed: The seed.

    Example:
        >>> seed_numbers(3), seed_numbers((3, 1)), seed_numbers(np.int64(3))
        ([3], [3, 1], [3])
    """
    if isinstance(seed, int | np.integer):
        return [int(seed)]
    return [int(number) for number in seed]
