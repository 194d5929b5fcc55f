"""Counts of a fuzz as a page of Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_HEAD = """# Damaged files

`python benchmarks/fuzz --files {files} --seed {seed} --out studies/results/fuzz.json` damages
{files} files of each kind and reads them as the commands do. *Read*: what was read is possible.
*Refused*: by an error of this project that names the file. Faults are a traceback of another
error, a value that no sound file holds, an error that does not name the file, memory beyond
{memory} GiB, no answer in {patience:.0f} s of the reader's own time, a process that ended.

| kind | read | refused | faults |
|---|---:|---:|---:|
"""


def page(result: Mapping[str, Any], memory: int, patience: float) -> str:
    """A table with a row for each kind, and one for all.

    Args:
        result: What the command prints.
        memory: Bytes beyond which a reader has taken too much.
        patience: Seconds that a reader has for a file.
    """
    head = _HEAD.format(
        files=result["files_of_each_kind"],
        seed=result["seed"],
        memory=memory // 2**30,
        patience=patience,
    )
    rows = [*result["kinds"].items(), ("all", result["total"])]
    lines = []
    for name, row in rows:
        faults = sum(row.values()) - row["read"] - row["refused"]
        lines.append(f"| {name} | {row['read']} | {row['refused']} | {faults} |\n")
    return head + "".join(lines)
