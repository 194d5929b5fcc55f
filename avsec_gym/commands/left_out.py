"""What a command did not do, for people: what was done before, and what it could not, and why."""

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


def say_kept(count: int, total: int, kind: str) -> None:
    """Report how many results are those of an earlier run, on standard error; nothing of none.

    Args:
        count: The number of these.
        total: The number of all.
        kind: The word for them, such as ``frames``.
    """
    if count:
        console.say(f"avsec: {count} of {total} {kind} are kept from an earlier run")
