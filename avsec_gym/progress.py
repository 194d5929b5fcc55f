"""How long work reports its progress: by a function that it calls as it goes on."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[int, int], None]
"""A function that gets the number of what is done, and that of all."""


def no_progress(done: int, total: int) -> None:
    """Show nothing.

    Args:
        done: The number of what is done.
        total: The number of all.
    """
