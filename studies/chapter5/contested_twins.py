"""Renders twins of some contested scenarios: streets on which it matters what a car sees.

    python -m studies.chapter5.contested_twins --kitti DIR --scenarios DIR --count N --out DIR

In most scenarios nothing that perception gets wrong can make the episode unsafe: few attacks turn
few episodes, and a study of which do learns little from hours of attacks.  Chosen by chance among
all that `is_contested` with some intention.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from avsec_gym.cli import run as avsec
from avsec_gym.errors import ConfigurationError
from avsec_gym.evaluation.contested import is_contested
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import labelled_scenarios
from avsec_gym.world.assets import Assets


def chosen(scenarios: SceneSet, count: int, seed: int = 0) -> list[str]:
    """Ids of contested street scenarios, sorted.

    Args:
        scenarios: The authors' labelled scenarios.
        count: How many contested ones are drawn; highways among them are left out, since a data
            set has one road type.
        seed: The seed of the draw.

    Raises:
        ConfigurationError: There are fewer.
    """
    contested = [
        scene
        for scene in scenarios.labelled
        if any(is_contested(scene, intention) for intention in Intention)
    ]
    if count > len(contested):
        raise ConfigurationError(f"{len(contested)} scenarios are contested, not {count}")
    numbers = np.random.default_rng(seed).choice(len(contested), count, replace=False)
    drawn = [contested[number] for number in sorted(numbers)]
    return [scene.id for scene in drawn if scene.road_type == RoadType.STREET]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kitti", type=Path, required=True, help="root of the object data")
    parser.add_argument("--scenarios", type=Path, required=True, help="the labelled scenarios")
    parser.add_argument("--count", type=int, required=True, help="how many of them are drawn")
    parser.add_argument("--out", type=Path, required=True, help="a data set")
    options = parser.parse_args(arguments)
    ids = chosen(labelled_scenarios(options.scenarios), options.count)
    words = ["world", "twin", "--kitti", str(options.kitti), "--road-type", "street"]
    # Detectors were not trained on the judging assets.
    words += ["--no-lidar", "--assets", str(Assets.JUDGE), "--out", str(options.out)]
    return avsec([*words, "--ids", *ids])


if __name__ == "__main__":
    sys.exit(main())
