"""Handles: arrays that a kernel is shown once, and finds again by one reference.

numba looks at every array that Python calls a kernel with, a fifth of a microsecond apiece; a
search has thirty, and many end after a handful of nodes.  At what is behind a handle it looks once.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numba
from numba import types
from numba.experimental import structref

from avsec_gym.kernels import kernel


@structref.register
class _HandleType(types.StructRef):
    """What numba calls the type of a `Handle`."""


class Handle(structref.StructRefProxy):
    """A tuple of arrays and numbers, `content` in kernels.

    The arrays are not copied: what is written into them is seen on both sides.
    """


structref.define_proxy(Handle, _HandleType, ["content"])  # type: ignore[no-untyped-call]


def handle_of(content: Any) -> Any:
    """A handle on a tuple of arrays and numbers.

    Args:
        content: The tuple; named ones keep their names.
    """
    # Without compilation, whatever has the attribute will do.
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return SimpleNamespace(content=content)
    return _held(content)


@kernel()
def _held(content: Any) -> Any:
    return Handle(content)  # type: ignore[no-untyped-call]
