"""The scenes of the benchmark's version, which stay the same: procedural, of judging assets.

`all` are layouts of streets and highways as they come.  `contested` are those in which it matters
what a car sees (`avsec_gym.evaluation.contested`), with the intentions for which it does: both as
they were when the version was frozen, whatever a later planner makes of them.  A digest of the
objects shows whether the package still makes these scenes.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.evaluation.contested import chosen_recipe
from avsec_gym.progress import Progress
from avsec_gym.scenario.frame_scenes import FrameScenes, frame_scenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import scene_of_layout
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.world.assets import Assets
from avsec_gym.world.export import cached
from avsec_gym.world.layouts import generate_layout

VERSION = 1
"""The version of the benchmark; results of two versions are not compared."""
ALL, CONTESTED = "all", "contested"
"""Names of the sets."""
FROZEN = f"version_{VERSION}.json"
"""What is frozen, beside this module; ``benchmarks/freeze.py`` writes it."""


@dataclass(frozen=True)
class Extent:
    """How many scenes of a set are used.

    Args:
        layouts: Where only objects count.
        frames: Where sensors are rendered, which takes two seconds a scene.
    """

    layouts: int
    frames: int


@dataclass(frozen=True)
class FrozenSet:
    """Scenes of the benchmark.

    Args:
        name: ``all`` or ``contested``.
        seed: Seed of the set of layouts; no network of the package has seen it.
        numbers: Numbers of the layouts.
        intentions: The driving intentions that count in each layout, by its number; None: all.
        full: How many of them an entry uses.
        quick: How many a quick one does.
        digest: What `digest_of` made of all of them when they were frozen.
    """

    name: str
    seed: int
    numbers: tuple[int, ...]
    intentions: Mapping[int, frozenset[Intention]] | None
    full: Extent
    quick: Extent
    digest: str

    def check(self) -> None:
        """Compare today's scenes with the frozen ones.

        Raises:
            ConfigurationError: This release makes other scenes.
        """
        if digest_of(self._scenes) != self.digest:
            raise refused(self.name)

    def count(self, *, images: bool, quick: bool = False) -> int:
        """How many scenes an entry uses, with images or without."""
        extent = self.quick if quick else self.full
        return extent.frames if images else extent.layouts

    def ids(self, *, quick: bool = False) -> list[str]:
        """The ids of the frames."""
        numbers = self.numbers[: self.count(images=True, quick=quick)]
        return [f"{number:06d}" for number in numbers]

    def layouts(self, *, quick: bool = False) -> SceneSet:
        """The scenes, without images."""
        scenes = self._scenes[: self.count(images=False, quick=quick)]
        ways = self._ways({scene.id: scene.number for scene in scenes})
        return SceneSet(self.name, tuple(scenes), intentions=ways)

    def frames(self, *, quick: bool = False, on_progress: Progress | None = None) -> FrameScenes:
        """The scenes with what the sensors deliver; rendered into the cache on first use.

        Args:
            quick: Whether only as many as a quick entry uses.
            on_progress: Function of the progress, as of `make_data_set`; None: it is logged.
        """
        count = self.count(images=True, quick=quick)
        numbers = self.numbers[:count]
        recipe = chosen_recipe(numbers, seed=self.seed, assets=Assets.JUDGE)
        name = f"benchmark-{VERSION}-{self.name}-{count}"
        found = frame_scenes(cached(name, recipe, on_progress=on_progress), seed=self.seed)
        ways = self._ways({scene.id: int(scene.id) for scene in found.scenes.labelled})
        scenes = replace(found.scenes, name=self.name, intentions=ways)
        return replace(found, scenes=scenes)

    @cached_property
    def _scenes(self) -> list[Scene]:
        layouts = (generate_layout(number, set_seed=self.seed) for number in self.numbers)
        return [scene_of_layout(layout, self.seed) for layout in layouts]

    def _ways(self, numbers: Mapping[str, int]) -> dict[str, frozenset[Intention]] | None:
        if self.intentions is None:
            return None
        return {id: self.intentions[number] for id, number in numbers.items()}


@cache
def frozen_sets() -> Mapping[str, FrozenSet]:
    """The sets of this version by their names."""
    return {name: _set(name, one) for name, one in version_file()["sets"].items()}


@cache
def version_file() -> Mapping[str, Any]:
    """All that is frozen of this version."""
    path = Path(__file__).with_name(FROZEN)
    return read_json_object(path, remedy="It belongs to the package: install it again.")


def refused(name: str) -> ConfigurationError:
    """The error that this release makes other scenes of a set than the version has."""
    return ConfigurationError(
        f"the scenes {name!r} of this release are not those of version {VERSION} of "
        "the benchmark: install a release whose changelog names that version"
    )


def digest_of(scenes: Iterable[Scene]) -> str:
    """Sixteen hexadecimal digits that stand for the objects of scenes, to the millimetre."""
    digest = hashlib.sha256()
    for scene in scenes:
        boxes = scene.boxes
        digest.update(f"{scene.number} {scene.road_type}\n".encode())
        columns = (*boxes.location.T, *boxes.dimensions.T, boxes.rotation_y)
        moving = [None] * len(boxes) if boxes.moving is None else boxes.moving.tolist()
        for category, moves, *numbers in zip(boxes.category, moving, *columns, strict=True):
            # Zero has one sign.
            places = " ".join(f"{round(float(number), 3) + 0.0:.3f}" for number in numbers)
            digest.update(f"{category} {moves} {places}\n".encode())
    return digest.hexdigest()[:16]


def _set(name: str, found: Mapping[str, Any]) -> FrozenSet:
    ways = found["intentions"]
    return FrozenSet(
        name=name,
        seed=found["seed"],
        numbers=tuple(found["numbers"]),
        intentions=None
        if ways is None
        else {int(number): frozenset(map(Intention, own)) for number, own in ways.items()},
        full=Extent(**found["full"]),
        quick=Extent(**found["quick"]),
        digest=found["digest"],
    )
