"""How many workers machines get, and how many threads each worker."""

from __future__ import annotations

from collections.abc import Sequence

_MOST_WORKERS = 4
"""The most workers on one machine, without being asked: each holds networks of its own."""


def room(cores: Sequence[int], threads: int) -> int:
    """Workers of so many threads that fit on machines, a core for each thread.

    Args:
        cores: The number of cores of each machine.
        threads: The number of threads of each worker.

    Example:
        >>> room([4, 3], threads=2)
        3
    """
    return sum(each // threads for each in cores)


def usual_workers(cores: Sequence[int], threads: int) -> int:
    """The number of workers: as many as fit, but no more than four on a machine, and one at least.

    Example:
        >>> usual_workers([16, 2], threads=1)
        6
    """
    return max(1, sum(min(_MOST_WORKERS, each // threads) for each in cores))


def usual_threads(cores: Sequence[int], workers: int | None) -> int:
    """Threads of each worker: as many as fit beside one another, and one at least.

    Args:
        cores: The number of cores of each machine.
        workers: The number of workers on all machines together; if None, up to four on each.

    Example:
        >>> usual_threads([8], workers=None), usual_threads([8, 8], workers=4)
        (2, 4)
    """
    if workers is None:
        return max(1, min((each // min(_MOST_WORKERS, each) for each in cores if each), default=1))
    wanted = max(1, workers)
    return max((t for t in range(1, max(cores) + 1) if room(cores, t) >= wanted), default=1)
