"""Freezes the scenes of a new version of the benchmark: writes avsec_gym/benchmark/version_N.json.

python benchmarks/freeze.py --seed 71001

A version that has been published is not frozen again: what exists is not overwritten.
"""

from __future__ import annotations

import argparse
import json
from itertools import islice
from pathlib import Path
from typing import Any

from avsec_gym.benchmark.scene_sets import FROZEN, digest_of
from avsec_gym.evaluation.contested import contested_numbers, is_contested
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_sets import scene_of_layout
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.layouts import generate_layout

ALL = {"full": {"layouts": 600, "frames": 100}, "quick": {"layouts": 60, "frames": 6}}
CONTESTED = {"full": {"layouts": 200, "frames": 80}, "quick": {"layouts": 20, "frames": 8}}


def main() -> None:
    """Choose the scenes and write them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, required=True, help="of both sets of layouts")
    seed = parser.parse_args().seed
    every = list(range(ALL["full"]["layouts"]))
    contested = list(islice(contested_numbers(seed + 1), CONTESTED["full"]["layouts"]))
    ways = {
        scene.number: [str(way) for way in Intention if is_contested(scene, way)]
        for scene in scenes(contested, seed + 1)
    }
    sets = {
        "all": frozen(every, seed, None) | ALL,
        "contested": frozen(contested, seed + 1, ways) | CONTESTED,
    }
    path = Path(__file__).parents[1] / "avsec_gym/benchmark" / FROZEN
    write_text(path, json.dumps({"sets": sets}, indent=1) + "\n")
    for name, found in sets.items():
        print(f"{path}: {name} {found['digest']}")


def frozen(numbers: list[int], seed: int, ways: Any) -> dict[str, Any]:
    """What is kept of a set, without its extent."""
    digest = digest_of(scenes(numbers, seed))
    return {"seed": seed, "numbers": numbers, "intentions": ways, "digest": digest}


def scenes(numbers: list[int], seed: int) -> list[Scene]:
    """The scenes of some layouts."""
    return [scene_of_layout(generate_layout(number, set_seed=seed), seed) for number in numbers]


if __name__ == "__main__":
    main()
