"""How many objects connected vehicles have in common, by how far apart they stand.

Run ``python -m studies.world.meetings > meetings.json``.  The places are the same in each distance.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from avsec_gym import console
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.rig import kitti_rig, resized_rig
from avsec_gym.world.export import Connection, Sensors, make_data_set, suite_recipe

SPACINGS = ((6.0, 20.0), (15.0, 60.0), (50.0, 90.0))
"""Least and greatest distance of the other vehicles from the first, metres."""
_IMAGE_WIDTH = 128
"""Scans alone count, so images are small."""


def meetings(instants: int, vehicles: int, seed: int, folder: Path) -> Iterator[dict[str, Any]]:
    """What vehicles at each distance see in common.

    Args:
        instants: Number of instants, each at a place of its own.
        vehicles: Number of vehicles with sensors.
        seed: Seed of the places.
        folder: Folder for the data sets.

    Yields:
        JSON-able: the distances, how many objects one or more vehicles see (5 points or more), how
        many of them 1, 2, ... vehicles do, and the share that two or more see with its interval.
    """
    sensors = Sensors(cameras=(2,), rig=resized_rig(kitti_rig(), _IMAGE_WIDTH))
    for near, far in SPACINGS:
        recipe = suite_recipe(
            "connected",
            instants,
            seed,
            sensors=sensors,
            vehicles=vehicles,
            connection=Connection(spacing=(near, far)),
        )
        root = folder / f"{near:g}_{far:g}"
        with console.progress(f"{near:g} to {far:g} m") as shown:
            make_data_set(recipe, root, on_progress=shown)
        found = json.loads((root / "meetings.json").read_text())
        shared = sum(found["seen_by"][1:])
        yield {
            "spacing": [near, far],
            **found,
            "interval": [round(end, 4) for end in wilson_interval(shared, found["objects"])],
        }


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the JSON; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--instants", type=int, default=15, help="of each distance")
    parser.add_argument("--vehicles", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        rows = list(meetings(options.instants, options.vehicles, options.seed, Path(folder)))
    json.dump({**vars(options), "distances": rows}, sys.stdout, indent=1)
    return 0


if __name__ == "__main__":
    sys.exit(main())
