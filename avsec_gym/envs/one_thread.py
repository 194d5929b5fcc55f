"""Networks on one thread, for environments that are the same in every process."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch, where it is loaded, compute on one thread.

    Networks round otherwise on another number of threads, and an episode is the same bit for bit
    in every process.  A forked process would also wait forever for the threads of its parent, even
    to fill a network with its weights.
    """
    torch = sys.modules.get("torch")
    if torch is None:
        yield
        return
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
