"""How long an answer is waited for: by the time a process got, not by a busy machine's clock."""

from __future__ import annotations

import os
import select
import time
from pathlib import Path
from typing import IO, Any

_LOOK = 0.25
"""Seconds between two looks at a process that has not answered."""
_TICKS = os.sysconf("SC_CLK_TCK")


def answers_in(answers: IO[Any], process: int, patience: float) -> bool:
    """Whether a process answers, or ends, before it hangs.

    It hangs once the time that it computed and the time that it slept, waiting for something, are
    `patience` seconds. The time in which other processes keep it from a CPU is neither.

    Args:
        answers: The reading end of its pipe.
        process: Its id.
        patience: Seconds.
    """
    begun, asleep = _cpu_time(process), 0.0
    computed, looked = begun, time.monotonic()
    while not select.select([answers], [], [], _LOOK)[0]:
        last, computed = computed, _cpu_time(process)
        before, looked = looked, time.monotonic()
        if computed == last and _sleeps(process):
            asleep += looked - before
        if computed - begun + asleep > patience:
            return False
    return True


def _cpu_time(process: int) -> float:
    """Seconds of all threads, in user code and in the kernel."""
    fields = _fields(Path(f"/proc/{process}/stat"))
    return (int(fields[11]) + int(fields[12])) / _TICKS


def _sleeps(process: int) -> bool:
    """Whether no thread runs, waits for a CPU or the disk, or is stopped."""
    threads = Path(f"/proc/{process}/task").iterdir()
    return all(_fields(thread / "stat")[0] in "SX" for thread in threads)


def _fields(stat: Path) -> list[str]:
    """What follows the name of the command, from the state on."""
    try:
        return stat.read_text().rsplit(")", 1)[1].split()
    except (FileNotFoundError, ProcessLookupError):  # A thread that has just ended.
        return ["X", *["0"] * 20]
