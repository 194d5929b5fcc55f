"""What a command could not do, for people: the first reasons one by one, then how many more."""

from __future__ import annotations

from collections.abc import Mapping

from avsec_gym import console

_REMARKS = 5
"""So many reasons are reported one by one."""


def say_left_out(left_out: Mapping[str, str], kind: str) -> None:
    """Report what was left out, on standard error.

    Args:
        left_out: The reasons, by what was left out.
        kind: The word for these, such as ``frames``.
    """
    for name, reason in list(left_out.items())[:_REMARKS]:
        console.say(f"avsec: left out: {name}: {reason}")
    if len(left_out) > _REMARKS:
        console.say(f"avsec: left out: {len(left_out) - _REMARKS} more {kind}")
