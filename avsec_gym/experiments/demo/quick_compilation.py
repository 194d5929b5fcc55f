"""Compiles kernels without looking for garbage meanwhile: a quarter of the time that it takes."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, cast

from numba.core import event

_COMPILATION = "numba:compile"


class _Uncollected(event.Listener):
    """Switches the collection off while something is compiled, and with it what that calls."""

    def __init__(self) -> None:
        self._open = 0
        self._was_on = False

    def on_start(self, event: event.Event) -> None:
        """A compilation begins; compilations have others within."""
        if not self._open:
            self._was_on = gc.isenabled()
            gc.disable()
        self._open += 1

    def on_end(self, event: event.Event) -> None:
        """A compilation has ended, well or not."""
        self._open -= 1
        if not self._open and self._was_on:
            gc.enable()


@contextmanager
def quick_compilation() -> Iterator[None]:
    """Within this context, numba compiles while Python collects no garbage.

    A compilation makes many small objects that live on; to look through them again and again costs
    as much as a quarter of it.  In between, all is as before.

    Example:
        >>> with quick_compilation():
        ...     gc.isenabled()  # Nothing is compiled yet.
        True
    """
    listener, events = _Uncollected(), cast(Any, event)
    events.register(_COMPILATION, listener)
    try:
        yield
    finally:
        events.unregister(_COMPILATION, listener)
