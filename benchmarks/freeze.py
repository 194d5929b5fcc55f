"""Freezes the scenes of a new version of the benchmark: writes avsec_gym/benchmark/version_N.json.

python benchmarks/freeze.py --seed 71001

Beside it, the error models of avsec_gym/benchmark/error_models are those that the package ships on
that day.  A version that has been published is not frozen again: what exists is not overwritten.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from itertools import count, islice
from pathlib import Path
from typing import Any

from avsec_gym.benchmark.connected_scenes import CONNECTED, FrozenInstants, digest_of_instant
from avsec_gym.benchmark.loop_scenes import (
    CLOSED_LOOP,
    ERROR_MODELS,
    LAYOUT,
    ROAD,
    FrozenDrives,
    digest_of_drives,
)
from avsec_gym.benchmark.scene_sets import FROZEN, digest_of
from avsec_gym.closed_loop.drive_record import Outcome
from avsec_gym.closed_loop.error_model.shipped import error_model_file
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.evaluation.contested import contested_numbers, is_contested
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_sets import scene_of_layout
from avsec_gym.storage.regular_files import read_bytes
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.layouts import generate_layout

ALL = {"full": {"layouts": 600, "frames": 100}, "quick": {"layouts": 60, "frames": 6}}
CONTESTED = {"full": {"layouts": 200, "frames": 80}, "quick": {"layouts": 20, "frames": 8}}
DRIVEN = {LAYOUT: 60, ROAD: 8}
"""Scenes of the closed loop."""
QUICK_DRIVEN = 6
INSTANTS, QUICK_INSTANTS = 48, 4
"""Places of connected vehicles."""
PLANNED_BY = ("dsgn", "dsgn_patch")
"""The error models that a planner meets: without an attack, and beside a patch."""
PACKAGE = Path(__file__).parents[1] / "avsec_gym/benchmark"


def main() -> None:
    """Choose the scenes and write them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, required=True, help="of the first set of scenes")
    seed = parser.parse_args().seed
    for path in (PACKAGE / FROZEN, PACKAGE / ERROR_MODELS):
        if path.exists():  # Rather than after the hour in which scenes are chosen.
            parser.error(f"{path} exists and is left as it is; remove it if it was never published")
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
    found = {
        "sets": sets,
        CLOSED_LOOP: frozen_drives(seed + 2),
        CONNECTED: frozen_instants(seed + 3),
    }
    write_text(PACKAGE / FROZEN, json.dumps(found, indent=1) + "\n")
    print(PACKAGE / FROZEN)


def frozen(numbers: list[int], seed: int, ways: Any) -> dict[str, Any]:
    """What is kept of a set, without its extent."""
    digest = digest_of(scenes(numbers, seed))
    return {"seed": seed, "numbers": numbers, "intentions": ways, "digest": digest}


def scenes(numbers: list[int], seed: int) -> list[Scene]:
    """The scenes of some layouts."""
    return [scene_of_layout(generate_layout(number, set_seed=seed), seed) for number in numbers]


def frozen_instants(seed: int) -> dict[str, Any]:
    """What is kept of the instants of connected vehicles."""
    instants = FrozenInstants(seed, {}, QUICK_INSTANTS)
    digests = {
        str(number): digest_of_instant(instants.place(number).posed.instant)
        for number in range(INSTANTS)
    }
    return {"seed": seed, "digests": digests, "quick": QUICK_INSTANTS}


def frozen_drives(seed: int) -> dict[str, Any]:
    """What is kept of the drives; their error models are copied."""
    ways: dict[str, list[str]] = {}
    for kind, most in DRIVEN.items():
        ways |= dict(islice(contested_drives(seed, kind), most))
    for name in PLANNED_BY:
        text = read_bytes(error_model_file(name), most=2**24).decode()
        write_text(PACKAGE / ERROR_MODELS / f"{name}.json", text)
    drives = unchecked(seed, [*ways])
    return {
        "seed": seed,
        "intentions": ways,
        "quick": QUICK_DRIVEN,
        "digest": digest_of_drives(map(drives.scenes.scene, drives.ids())),
        "quick_digest": digest_of_drives(map(drives.scenes.scene, drives.ids(quick=True))),
        "error_models": [*PLANNED_BY],
    }


def unchecked(seed: int, ids: list[str]) -> FrozenDrives:
    """The drives of some ids before anything is frozen of them."""
    return FrozenDrives(seed, dict.fromkeys(ids, ()), QUICK_DRIVEN, "", "", {})


def contested_drives(seed: int, kind: str) -> Iterator[tuple[str, list[str]]]:
    """Scenes that are contested in closed loop, and with which intentions, without end.

    A blind car collides by its own fault or leaves the road; one that knows the truth reaches its
    goal.
    """
    for number in count():
        id = f"{kind}-{number:06d}"
        alone = unchecked(seed, [id]).scenes
        cars = [
            DriveSetting(name, {"perception": name}).environment(alone)
            for name in ("blind", "truth")
        ]
        ways = []
        for way in map(str, alone.scene(id).intentions):
            blind = drive(cars[0], DriveTask("blind", id, way, 0)).row
            if not blind["at_fault"] and blind["outcome"] != Outcome.OFF_ROAD:
                continue
            if drive(cars[1], DriveTask("truth", id, way, 0)).row["outcome"] == Outcome.GOAL:
                ways.append(way)
        if ways:
            yield id, ways


if __name__ == "__main__":
    main()
