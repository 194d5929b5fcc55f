"""Render contested scenes alone, to learn in and to be judged by.

    python -m studies.attackers.contested_scenes --seed 7320 --assets train --out FOLDER

In three layouts of four nothing is in the way, and they would be rendered for nothing.  A command
that was stopped goes on where it was; more frames continue a set.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from avsec_gym.console import progress
from avsec_gym.evaluation.contested import contested_recipe
from avsec_gym.rig import kitti_rig, resized_rig
from avsec_gym.world.assets import Assets
from avsec_gym.world.export import Sensors, make_data_set
from studies.answer import exit_code


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--frames", type=int, default=240, help="number of scenes")
    parser.add_argument("--seed", type=int, required=True, help="of the set of layouts")
    parser.add_argument("--assets", type=Assets, required=True, help="train, judge or all")
    parser.add_argument("--width", type=int, default=640, help="of the images, pixels")
    parser.add_argument("--lidar", action="store_true", help="scans, too")
    parser.add_argument("--out", type=Path, required=True, help="folder of the data set")
    options = parser.parse_args(arguments)

    def work() -> None:
        sensors = Sensors((2, 3), lidar=options.lidar, rig=resized_rig(kitti_rig(), options.width))
        recipe = contested_recipe(
            options.frames, seed=options.seed, sensors=sensors, assets=options.assets
        )
        with progress("rendering scenes") as shown:
            make_data_set(recipe, options.out, on_progress=shown)

    return exit_code(work)


if __name__ == "__main__":
    sys.exit(main())
