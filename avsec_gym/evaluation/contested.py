"""Contested scenes: those in which it matters what a car sees.

In most scenes a car that sees nothing drives as safely as one that sees all, since nothing is in
its way: there detectors and attacks differ by chance alone.  A scene is contested with a driving
intention if a car that believes in no object drives unsafely, and one that believes in all real
ones, standing, drives safely.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count, islice
from pathlib import Path
from typing import Any

from avsec_gym.argument_checks import whole_number
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import Planner
from avsec_gym.progress import Progress
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import scene_of_layout
from avsec_gym.world.assets import Assets
from avsec_gym.world.export import LayoutFrames, Sensors, cached
from avsec_gym.world.layouts import MOST_LAYOUTS, generate_layout

LAYOUTS, FRAMES = 100, 48
"""Scenes of the procedural set, without images and with them."""


def is_contested(scene: Scene, intention: Intention, planner: Planner | None = None) -> bool:
    """Whether an episode is unsafe for a blind car, and safe for one that sees all.

    Args:
        scene: The real scene.
        intention: The driving intention.
        planner: The motion planner; None: A* over motion primitives.

    Example:
        >>> from avsec_gym.scenario.scene_sets import procedural_scenes
        >>> scenes = procedural_scenes(16).labelled
        >>> [scene.id for scene in scenes if is_contested(scene, Intention.RIGHT)]
        ['street-000013']
    """

    def safe(believed: Boxes3D | None) -> bool:
        episode = run_episode(scene, intention, believed, motion=Motion.STATIC, planner=planner)
        return episode.record.safe

    return not safe(Boxes3D.empty()) and safe(None)


def contested(scenes: SceneSet) -> SceneSet:
    """The scenes that are contested with some intention, and with which.

    Args:
        scenes: Scenes with labelled objects.

    Raises:
        ConfigurationError: None is contested.
    """
    ways = {
        scene.id: frozenset(way for way in scene.intentions if is_contested(scene, way))
        for scene in scenes.labelled
    }
    chosen = tuple(scene for scene in scenes.scenes if ways[scene.id])
    if not chosen:
        raise ConfigurationError(
            f"none of the {len(scenes)} scenes of {scenes.name} is contested: blind or not, a car "
            "drives as safely in all of them; name more scenes, or leave `contested` out"
        )
    name = f"{scenes.name}, contested"
    return replace(scenes, name=name, scenes=chosen, intentions={s.id: ways[s.id] for s in chosen})


def contested_layouts(scenes: int | None = None, *, seed: int = 0) -> SceneSet:
    """The set ``mixed_contested`` without images: the first procedural scenes that are contested.

    Args:
        scenes: Number of scenes, 1 to `MOST_LAYOUTS`; None: `LAYOUTS`.
        seed: Seed of the set of layouts.

    Raises:
        ConfigurationError: Another number of scenes.
    """
    wanted = whole_number("scenes", LAYOUTS if scenes is None else scenes, 1, MOST_LAYOUTS)
    numbers = tuple(islice(contested_numbers(seed), wanted))
    every = tuple(scene_of_layout(generate_layout(n, set_seed=seed), seed) for n in numbers)
    return replace(contested(SceneSet("", every)), name="mixed_contested")


def contested_frames(
    frames: int = FRAMES, *, seed: int = 0, on_progress: Progress | None = None
) -> Path:
    """The set ``mixed_contested`` with images, in KITTI's object layout, with scans.

    It is rendered into the cache on first use.

    Args:
        frames: Number of frames.
        seed: Seed of the set of layouts; the package's networks know some below 10000, which the
            cards of their weights name.
        on_progress: Function of the progress, as of `make_data_set`; None: it is logged.

    Raises:
        ConfigurationError: A number of frames that is not from 1 to `MOST_LAYOUTS`.
    """
    recipe = contested_recipe(frames, seed=seed)
    return cached(f"contested-{seed}-{frames}", recipe, on_progress=on_progress)


def contested_recipe(
    frames: int,
    *,
    seed: int = 0,
    sensors: Sensors = Sensors(),
    assets: Assets = Assets.ALL,
) -> ChosenFrames:
    """How the first contested scenes of a set of layouts are rendered.

    Args:
        frames: Number of frames.
        seed: Seed of the set of layouts.
        sensors: What is rendered of each.
        assets: The part of the assets that all places and actors are made of.

    Raises:
        ConfigurationError: A number of frames that is not from 1 to `MOST_LAYOUTS`.
    """
    whole_number("frames", frames, 1, MOST_LAYOUTS)
    numbers = tuple(islice(contested_numbers(seed), frames))
    return chosen_recipe(numbers, seed=seed, sensors=sensors, assets=assets, chosen="contested")


def chosen_recipe(
    numbers: Sequence[int],
    *,
    seed: int = 0,
    sensors: Sensors = Sensors(),
    assets: Assets = Assets.ALL,
    chosen: str | Sequence[int] | None = None,
) -> ChosenFrames:
    """How some scenes of a set of layouts are rendered.

    Args:
        numbers: The numbers of the layouts.
        seed: Seed of the set of layouts.
        sensors: What is rendered of each.
        assets: The part of the assets that all places and actors are made of.
        chosen: The rule that chose them, if it has a name; None: the numbers stand for themselves.
    """
    rule = [*numbers] if chosen is None else chosen
    frames = len(numbers)
    return ChosenFrames(
        "mixed", frames, seed, sensors, assets=assets, numbers=tuple(numbers), chosen=rule
    )


@dataclass(frozen=True, eq=False)
class ChosenFrames(LayoutFrames):
    """The frames of a suite whose numbers are given.

    Args:
        numbers: The numbers of the layouts.
        chosen: The rule that chose them.
    """

    numbers: tuple[int, ...] = ()
    chosen: str | Sequence[int] = ()

    @property
    def settings(self) -> dict[str, Any]:
        """See `Recipe`."""
        return super().settings | {"chosen": self.chosen}

    def last_file(self, number: int) -> str:
        """See `Recipe`."""
        return super().last_file(self.numbers[number])

    def make(self, root: Path, number: int) -> list[str]:
        """See `Recipe`."""
        return super().make(root, self.numbers[number])


def contested_numbers(seed: int) -> Iterator[int]:
    """Numbers of the contested layouts of a set, without end.

    Args:
        seed: Seed of the set of layouts.
    """
    for number in count():
        scene = scene_of_layout(generate_layout(number, set_seed=seed), seed)
        if any(is_contested(scene, way) for way in Intention):
            yield number
