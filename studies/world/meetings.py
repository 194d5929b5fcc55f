"""How many objects connected vehicles have in common, by how far apart they stand.

Run ``python -m studies.world.meetings > meetings.json``.  The places are the same in each distance.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from avsec_gym import console
from avsec_gym.experiments.json_rows import row_json
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.rig import kitti_rig, resized_rig
from avsec_gym.world.export import (
    MEETINGS,
    ConnectedWorld,
    Connection,
    Sensors,
    make_data_set,
    suite_recipe,
)

SPACINGS = ((6.0, 20.0), (15.0, 60.0), (50.0, 90.0))
"""Least and greatest distance of the other vehicles from the first, metres."""
_IMAGE_WIDTH = 128
"""Scans alone count, so images are small."""


@dataclass(frozen=True)
class Meeting:
    """What vehicles at a distance see in common."""

    spacing: tuple[float, float]
    """Least and greatest distance of the other vehicles from the first, metres."""
    instants: int
    objects: int
    """How many one or more vehicles see (5 points or more)."""
    seen_by: list[int]
    """How many of them 1, 2, ... vehicles see."""
    shared: float
    """The share that two or more see."""
    interval: tuple[float, float]
    """Interval of this share, 95 %; the objects of one instant belong together."""


@dataclass(frozen=True)
class Meetings:
    """The result, with what was asked for."""

    instants: int
    vehicles: int
    seed: int
    distances: list[Meeting]


def meetings(instants: int, vehicles: int, seed: int, folder: Path) -> Iterator[Meeting]:
    """What vehicles at each distance see in common.

    Args:
        instants: Number of instants, each at a place of its own.
        vehicles: Number of vehicles with sensors.
        seed: Seed of the places.
        folder: Folder for the data sets.

    Yields:
        What they see, for each of `SPACINGS`.
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
        found = json.loads((root / MEETINGS).read_text())
        low, high = _interval(ConnectedWorld(root))
        yield Meeting(spacing=(near, far), **found, interval=(round(low, 4), round(high, 4)))


def _interval(world: ConnectedWorld) -> tuple[float, float]:
    """Of the share of seen objects that two vehicles or more see; 0 to 1 where none is seen."""
    seen = [(id, len(each.seen_by)) for id in world.ids() for each in world.instant(id).objects]
    counted = [(id, vehicles > 1) for id, vehicles in seen if vehicles]
    share = share_of([shared for _, shared in counted], [id for id, _ in counted])
    return share.interval or (0.0, 1.0)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the JSON; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--instants", type=int, default=15, help="of each distance")
    parser.add_argument("--vehicles", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        rows = list(meetings(options.instants, options.vehicles, options.seed, Path(folder)))
    json.dump(row_json(Meetings(**vars(options), distances=rows)), sys.stdout, indent=1)
    return 0


if __name__ == "__main__":
    sys.exit(main())
