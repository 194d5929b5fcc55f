"""The table of 300 scenes in closed loop: rates and scores of each setting in each set of scenes.

    python -m studies.driving_safety.closed_loop --runs runs/closed_loop --json closed_loop.json

reads what `avsec drive` left in ``labels``, ``drives`` and ``tracking`` below that folder, of these
those that are there.  The study of this name (`python -m studies closed_loop`) has the commands.
Settings that are added, such as an error model of a detector under an attack, come into the table
by themselves.  Every collision at fault under truth is listed, with its certificate if no car could
have avoided it.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from avsec_gym.closed_loop.loop_scenes import loop_scenes
from avsec_gym.closed_loop.unavoidable import unavoidable
from avsec_gym.drives.drive_folder import RECORD, ROWS
from avsec_gym.drives.summary import by_recording, by_scene, summaries
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.text_files import read_text, write_text

SETS = {"labels": by_scene, "drives": by_scene, "tracking": by_recording}
"""Folders, and which of their drives are one cluster."""
TRUTH = "truth"


def table(folder: Path) -> dict[str, Any]:
    """What the drives in a folder come to, by setting.

    Args:
        folder: A folder of `avsec drive`, named as one of `SETS`.
    """
    rows = [json.loads(line) for line in read_text(folder / ROWS).splitlines() if line]
    settings = list(dict.fromkeys(row["setting"] for row in rows))
    summary = summaries(rows, settings, SETS[folder.name])
    return {
        "clusters": len({SETS[folder.name](row) for row in rows}),
        "settings": [each.to_json() for each in summary],
        "truth_at_fault": _explained(folder, rows),
    }


def _explained(folder: Path, rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The collisions at fault of a car that knew the truth."""
    blamed = [row for row in rows if row["setting"] == TRUTH and row["at_fault"]]
    if not blamed:
        return []
    record = read_json_object(folder / RECORD, remedy="Run `avsec drive` again.")
    scenes = loop_scenes(**record["scenarios"])
    found = []
    for row in blamed:
        proof = unavoidable(scenes.scene(row["scenario"]))
        unavoidable_after = None if proof is None else proof.time
        found.append(
            {
                "scenario": row["scenario"],
                "intention": row["intention"],
                "unavoidable_after": unavoidable_after,
            }
        )
    return found


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=Path, required=True)
    parser.add_argument("--json", type=Path, required=True)
    given = parser.parse_args()
    result = {name: table(given.runs / name) for name in SETS if (given.runs / name).is_dir()}
    write_text(given.json, json.dumps(result, indent=1) + "\n", overwrite=True)


if __name__ == "__main__":
    main()
