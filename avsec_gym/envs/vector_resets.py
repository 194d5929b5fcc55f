"""What users may give to the reset of many environments at once: seeds, and a mask."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import shown, whole_number
from avsec_gym.errors import ConfigurationError


def generators_of(
    seed: Any, count: int, before: list[np.random.Generator]
) -> list[np.random.Generator]:
    """A generator of random numbers for each environment.

    Args:
        seed: A seed s, of which environment i gets s + i; or one for each; None: it is not changed.
        count: Number of environments.
        before: The environments' generators so far; empty: there are none.

    Raises:
        ConfigurationError: A seed is no whole number from 0 on, or there is not one for each.
    """
    if seed is None and before:
        return before
    given = seeds_of(seed, count)
    fresh = [gym.utils.seeding.np_random(each)[0] for each in given]
    return [
        kept if each is None else new
        for each, new, kept in zip(given, fresh, before or fresh, strict=True)
    ]


def mask_of(given: Any, count: int) -> NDArray[np.bool_]:
    """A copy of the mask of the episodes that begin.

    Raises:
        ConfigurationError: It is no array of so many flags.
    """
    is_mask = isinstance(given, np.ndarray) and given.dtype == bool
    if not is_mask or given.shape != (count,):
        raise ConfigurationError(
            f"reset_mask is a NumPy array of {count} flags, got {shown(given)}"
        )
    return np.array(given)


def seeds_of(seed: Any, count: int) -> list[int | None]:
    """One for each environment: those of a list, or consecutive ones; None where none is given.

    Args:
        seed: A seed s, of which environment i gets s + i; or one for each; None: none.
        count: Number of environments.

    Raises:
        ConfigurationError: A seed is no whole number from 0 on, or there is not one for each.
    """
    if not isinstance(seed, list | tuple):
        first = None if seed is None else whole_number("seed", seed, 0)
        return [None if first is None else first + i for i in range(count)]
    if len(seed) != count:
        raise ConfigurationError(
            f"reset takes one seed, or one for each of {count} environments, got {len(seed)}"
        )
    return [None if each is None else whole_number("seed", each, 0) for each in seed]
