"""Freezes the labelled KITTI scenarios of a new version: avsec_gym/benchmark/kitti_N.json.

python benchmarks/freeze_kitti.py --labels ../shared/safety_scenarios

Names and hashes of the files are kept, and the intentions that are contested by the planner of that
day.
A version that has been published is not frozen again: what exists is not overwritten.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from avsec_gym.benchmark.kitti_scenes import FROZEN, hashes_of
from avsec_gym.evaluation.contested import contested
from avsec_gym.scenario.scene_sets import labelled_scenarios
from avsec_gym.storage.text_files import write_text

PACKAGE = Path(__file__).parents[1] / "avsec_gym/benchmark"


def main() -> None:
    """Look at the files and write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--labels", type=Path, required=True, help="the labelled scenarios")
    root = parser.parse_args().labels
    path = PACKAGE / FROZEN
    if path.exists():
        parser.error(f"{path} exists and is left as it is; remove it if it was never published")
    ways = contested(labelled_scenarios(root)).intentions or {}
    found = {
        "files": hashes_of(root),
        "contested": {id: sorted(map(str, own)) for id, own in sorted(ways.items())},
    }
    write_text(path, json.dumps(found, indent=0) + "\n")
    print(path)


if __name__ == "__main__":
    main()
