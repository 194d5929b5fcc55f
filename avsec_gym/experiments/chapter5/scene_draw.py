"""The scenes that costly attacks are measured on: drawn by a seed, everywhere the same."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from avsec_gym.argument_checks import whole_number


def drawn_scenes(ids: Sequence[str], count: int, seed: int) -> tuple[str, ...]:
    """So many of the scenes, without replacement, each as likely as any other.

    Every scene has a place in a queue, by the SHA-256 of ``"SEED ID"``; the first `count` are
    drawn.  A scene's place hangs on nothing but the seed and its own id.  So a larger draw holds a
    smaller one, a run that has only some of the scenes draws among them in the same order, and a
    reader can draw the same scenes anew.

    Args:
        ids: Ids of the scenes, each once.
        count: How many are drawn; all where there are no more.
        seed: Seed of the draw.

    Returns:
        The drawn ids, in the order of `ids`.

    Raises:
        ConfigurationError: The count is no whole number of 1 or more.

    Example:
        >>> drawn_scenes(["000001", "000002", "000003", "000004"], 2, seed=0)
        ('000003', '000004')
    """
    count = whole_number("drawn_scenes", count, 1)
    queue = sorted(ids, key=lambda id: hashlib.sha256(f"{seed} {id}".encode()).digest())
    drawn = set(queue[:count])
    return tuple(id for id in ids if id in drawn)
