"""The drives of the benchmark's version in closed loop, which stay the same.

Most of the scenes are layouts on straight lanes, whose movers keep their speed; the others are
drives on the procedural world's own roads, in its recorded traffic.  All are contested in closed
loop, as they were when the version was frozen: a car that sees nothing collides by its own fault or
leaves the road, and one that knows the truth reaches its goal.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any

from avsec_gym.benchmark.scene_sets import refused, version_file
from avsec_gym.closed_loop.loop_scenes import LoopScenes
from avsec_gym.closed_loop.procedural_drives import procedural_drive
from avsec_gym.closed_loop.traffic_scene import TrafficScene, scene_on_straight_lanes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_sets import scene_of_layout
from avsec_gym.world.layouts import generate_layout

CLOSED_LOOP = "closed_loop"
"""Name of the set."""
LAYOUT, ROAD = "layout", "road"
"""What the ids of scenes begin with: straight lanes, or a road of the procedural world."""
Ways = Mapping[str, tuple[Intention, ...]]
_EVERY = 10
"""A digest knows every tenth step of a track, one second."""


@dataclass(frozen=True)
class FrozenDrives:
    """Scenes to drive in, with the intentions that count in each.

    Args:
        seed: Seed of layouts and roads; no network of the package has seen it.
        ways: Intentions by the scene's id, such as ``layout-000012`` or ``road-000003``.
        quick: The number of scenes of a quick entry, the first ones.
        digest: What `digest_of_drives` made of all of them when they were frozen.
        quick_digest: What it made of those of a quick entry.
        error_models: The errors that a planner meets, by name: files beside this module.
    """

    seed: int
    ways: Ways
    quick: int
    digest: str
    quick_digest: str
    error_models: Mapping[str, Path]

    def ids(self, *, quick: bool = False) -> list[str]:
        """The ids of the scenes of an entry, in order."""
        return [*self.ways][: self.quick if quick else None]

    @property
    def scenes(self) -> LoopScenes:
        """The scenes, each made when it is driven in."""
        return LoopScenes(tuple(self.ways), self._scene)

    def number(self, id: str, way: Intention) -> int:
        """The seed of a drive, the same under every setting: its place among all."""
        drives = [(scene, each) for scene, own in self.ways.items() for each in own]
        return drives.index((id, way))

    def check(self, *, quick: bool = False) -> None:
        """Compare today's scenes with the frozen ones.

        Args:
            quick: Whether only those of a quick entry are made, which takes no time.

        Raises:
            ConfigurationError: This release makes other scenes.
        """
        frozen = self.quick_digest if quick else self.digest
        if digest_of_drives(map(self._scene, self.ids(quick=quick))) != frozen:
            raise refused(CLOSED_LOOP)

    def _scene(self, id: str) -> TrafficScene:
        kind, _, number = id.partition("-")
        if kind == ROAD:
            return procedural_drive(self.seed, int(number))
        layout = generate_layout(int(number), set_seed=self.seed)
        return scene_on_straight_lanes(scene_of_layout(layout, self.seed))


@cache
def frozen_drives() -> FrozenDrives:
    """The drives of this version."""
    found = version_file()[CLOSED_LOOP]
    folder = Path(__file__).with_name(ERROR_MODELS)
    return FrozenDrives(
        seed=found["seed"],
        ways={id: tuple(map(Intention, own)) for id, own in found["intentions"].items()},
        quick=found["quick"],
        digest=found["digest"],
        quick_digest=found["quick_digest"],
        error_models={name: folder / f"{name}.json" for name in found["error_models"]},
    )


ERROR_MODELS = "error_models"
"""Folder of the frozen error models, beside this module."""


def digest_of_drives(scenes: Iterable[TrafficScene]) -> str:
    """Sixteen hexadecimal digits that stand for start, lanes and traffic, to the millimetre."""
    digest = hashlib.sha256()
    for scene in scenes:
        for line in _lines(scene):
            digest.update(f"{line}\n".encode())
    return digest.hexdigest()[:16]


def _lines(scene: TrafficScene) -> Iterator[str]:
    start, tracks = scene.start, scene.tracks
    begins = [start.x, start.y, start.heading, start.velocity]
    yield f"{scene.road_type} {_rounded([*begins, *scene.cruise])}"
    for lane in scene.road.lanelets:
        yield _rounded(chain(*lane.left, *lane.right))
    for row, category in enumerate(tracks.categories.tolist()):
        first, last = int(tracks.first[row]), int(tracks.last[row])
        poses = tracks.poses[row, first : last + 1 : _EVERY, :2].ravel().tolist()
        yield f"{category} {first} {last} {_rounded([*tracks.dimensions[row].tolist(), *poses])}"


def _rounded(numbers: Iterable[Any]) -> str:
    # Zero has one sign.
    return " ".join(f"{round(float(number), 3) + 0.0:.3f}" for number in numbers)
