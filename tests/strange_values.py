"""Values that a user may give for an argument, few of them sensible: no test module."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

STRANGE: tuple[Any, ...] = (
    *(None, True, False, "", "a", "1", b"a", 1j),
    *(0, 1, -1, 2, 7, 10**9, -(10**9), 10**30),
    *(0.0, 0.5, 1.5, -1.0, 1e9, float("nan"), float("inf"), -float("inf")),
    *([], {}, (), [1], ["a"], [None, None], [1, 2, 3], ["a", "b"], [[1, 2], [3, 4]], [[1], 2]),
    *((-100, 100), (5, 1e9), (2, 1), (1, 1), (0, 0.5), (3, float("nan")), [1.5, "b"]),
    *({"name": None}, {"name": "a"}, {"name": []}, {"a": 1}, {1: 2}, {"name": "astar", "a": 1}),
    *({"source": 5}, {"source": []}, {"source": "mixed", "count": "a"}, {"count": 10**9}),
    *({"name": "layouts", "count": 10**9}, {"name": "layouts", "count": 1.5}, {"first": -1}),
    *({"source": "mixed", "seed": None}, {"name": "layouts", "seed": "a"}, {"name": ["a"]}),
    *(np.int64(3), np.float32(0.5), np.bool_(True), np.zeros(2), np.zeros((2, 2)), np.array(5)),
    *(object(), object, len, Path("/no/such/folder"), Path(), "\0", "x" * 5000),
)
"""One list for all: what is wrong for one argument is right for another."""
