"""Makes the digital twins of the authors' labelled scenarios, on which chapter 5 is run.

python -m studies.chapter5.twins --kitti ROOT --scenarios DIR --out runs/twins
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from avsec_gym.cli import run as avsec
from avsec_gym.world.assets import Assets

PARTS = {
    "highway": ("road_dynamic_label",),
    "street": ("dynamic_label", "static_label", "nocar"),
}
"""Road type -> folders of the labelled scenarios."""


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kitti", type=Path, required=True, help="root of the object data")
    parser.add_argument("--scenarios", type=Path, required=True, help="the labelled scenarios")
    parser.add_argument("--out", type=Path, required=True, help="a data set for each road type")
    parser.add_argument(
        "--assets",
        choices=[str(part) for part in Assets],
        default=str(Assets.JUDGE),
        help="the part of all cars, houses and textures; detectors were not trained on judge",
    )
    options = parser.parse_args(arguments)
    for road_type, parts in PARTS.items():
        files = (file for part in parts for file in (options.scenarios / part).glob("*.txt"))
        words = ["world", "twin", "--kitti", str(options.kitti), "--road-type", road_type]
        words += ["--no-lidar", "--assets", options.assets]
        words += ["--out", str(options.out / road_type), "--ids"]
        if code := avsec([*words, *sorted(file.stem for file in files)]):
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main())
