"""Kinds of files that a fuzz is done with, kept line by line, so that a stopped one goes on."""

from __future__ import annotations

import hashlib
import json
import threading
from collections import Counter
from pathlib import Path
from typing import Any

_ROOT = Path(__file__).parents[2]


class DoneKinds:
    """Outcomes of kinds, in a file of one JSON line each.

    A line counts for the same number of files, the same seed and the same sources.

    Args:
        path: The file; None: nothing is kept.
        files: Damaged files of each kind.
        seed: Of the damage.
    """

    def __init__(self, path: Path | None, *, files: int, seed: int) -> None:
        self._path = path
        self._of = {"files": files, "seed": seed, "sources": _digest_of_sources()}
        self._lock = threading.Lock()
        self._known: dict[str, tuple[Counter[str], list[dict[str, Any]]]] = {}
        if path is not None and path.exists():
            for line in path.read_text().splitlines():
                row = json.loads(line)
                if row["of"] == self._of:
                    self._known[row["kind"]] = (Counter(row["counts"]), row["faults"])

    def get(self, kind: str) -> tuple[Counter[str], list[dict[str, Any]]] | None:
        """Outcomes and faults of a kind; None: it is not done."""
        return self._known.get(kind)

    def add(self, kind: str, counts: Counter[str], faults: list[dict[str, Any]]) -> None:
        """Keep a kind's outcomes; threads may do so at once."""
        if self._path is None:
            return
        row = {"of": self._of, "kind": kind, "counts": counts, "faults": faults}
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._lock, self._path.open("a") as file:
            file.write(json.dumps(row) + "\n")


def _digest_of_sources() -> str:
    digest = hashlib.sha256()
    for folder in ("avsec_gym", "benchmarks/fuzz"):
        for file in sorted((_ROOT / folder).rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]
