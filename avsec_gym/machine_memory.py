"""How much of the machine's memory one thing may take."""

from __future__ import annotations

import math
import os
from functools import cache


@cache
def half_of_memory() -> float:
    """Half of the machine's memory, bytes; without a limit where the system does not state it.

    Systems hand out more than they have, and then end the process that uses it.
    """
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2
    except (AttributeError, OSError, ValueError):
        return math.inf
