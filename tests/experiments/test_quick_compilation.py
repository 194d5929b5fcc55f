"""Compilation without collection: what is compiled is the same, and what was before is so again."""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any

import numba
import pytest

from avsec_gym.experiments.demo.quick_compilation import quick_compilation

compiled: Any = numba.njit


def test_garbage_is_collected_except_while_something_is_compiled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    switched: list[str] = []

    def noted(name: str, switch: Callable[[], None]) -> Callable[[], None]:
        def switching() -> None:
            switched.append(name)
            switch()

        return switching

    for name in ("disable", "enable"):
        monkeypatch.setattr(gc, name, noted(name, getattr(gc, name)))

    @compiled  # type: ignore[untyped-decorator]
    def inner(x: float) -> float:
        return x + 1.0

    @compiled  # type: ignore[untyped-decorator]
    def outer(x: float) -> float:
        return inner(x) * 2.0

    with quick_compilation():
        assert gc.isenabled()
        assert outer(1.0) == 4.0
        assert gc.isenabled()
    assert switched == ["disable", "enable"]  # Once, around both.

    @compiled  # type: ignore[untyped-decorator]
    def broken(x: Any) -> Any:
        return x.unheard_of

    with quick_compilation(), pytest.raises(numba.TypingError):
        broken(1.0)
    assert gc.isenabled()
    outer.py_func(1.0)
    assert outer(1) == 4  # Another signature, compiled after the context, leaves it alone.
    assert switched == ["disable", "enable"] * 2


def test_who_collects_nothing_collects_nothing_afterwards() -> None:
    @compiled  # type: ignore[untyped-decorator]
    def doubled(x: float) -> float:
        return 2.0 * x

    gc.disable()
    try:
        with quick_compilation():
            doubled(1.0)
        assert not gc.isenabled()
    finally:
        gc.enable()
