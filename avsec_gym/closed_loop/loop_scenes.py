"""Sets of scenes to drive in, by name or folder; a scene is made when it is driven."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avsec_gym.argument_checks import one_of, whole_number
from avsec_gym.closed_loop.recorded.sources import EVERY, KITTI_RAW, KITTI_TRACKING
from avsec_gym.closed_loop.traffic_scene import (
    TrafficScene,
    scene_of_commonroad,
    scene_on_straight_lanes,
)
from avsec_gym.errors import ConfigurationError
from avsec_gym.scenario.frame_scenes import frame_scenes
from avsec_gym.scenario.given_scene import GivenScene
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import KITTI_CONTESTED, LAYOUTS, MIXED_CONTESTED, scene_set
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.suggestions import unknown_name
from avsec_gym.world.assets import Assets
from avsec_gym.world.layouts import MOST_LAYOUTS

DRIVES = "drives"
"""Names procedural drives on the world's own road."""
NAMED = (LAYOUTS, MIXED_CONTESTED, KITTI_CONTESTED, DRIVES, KITTI_TRACKING, KITTI_RAW)
"""All names of scenes to drive in."""
_DRIVES_COUNT = 100
_MOST_VEHICLES = 10
"""Each scans anew at every instant, which takes half a second and more."""


@dataclass(frozen=True, eq=False)
class LoopScenes:
    """Scenes to drive in.

    Args:
        ids: The scenes' ids, in order.
        make: Function that makes the scene of an id.
    """

    ids: tuple[str, ...]
    make: Callable[[str], TrafficScene]

    def __len__(self) -> int:
        return len(self.ids)

    def scene(self, id: str) -> TrafficScene:
        """The scene of an id.

        Raises:
            ConfigurationError: There is none.
            DataError: A file of it is missing or broken.
        """
        if not isinstance(id, str) or id not in self.ids:
            problem = f"there is no scenario {id!r} among the {len(self.ids)} of this set"
            raise ConfigurationError(unknown_name(problem, str(id), self.ids))
        return self.make(id)

    def draw(
        self, generator: np.random.Generator, id: str | None, intentions: Sequence[Intention]
    ) -> tuple[TrafficScene, Intention]:
        """A scene, and an intention that it has a lane for.

        Args:
            generator: The generator that draws both.
            id: Id of the scene; None: it is drawn.
            intentions: The intentions to draw from.

        Raises:
            ConfigurationError: There is no such scene, or no lane for any of the intentions.
        """
        unfit = set[int]()
        while len(unfit) < len(self.ids):
            # Both are drawn in any case, so that a given id does not change what is drawn later.
            row, share = int(generator.integers(len(self.ids))), float(generator.random())
            scene = self.scene(self.ids[row] if id is None else id)
            fitting = [each for each in intentions if each in scene.intentions]
            if fitting:
                return scene, fitting[int(share * len(fitting))]
            unfit.add(row)
            if id is not None:
                scene.target_lane(intentions[0])
        raise ConfigurationError(f"no scene has a lane for the intention {str(intentions[0])!r}")


def loop_scenes(
    source: str | Path = DRIVES,
    *,
    kitti: str | Path | None = None,
    seed: int = 0,
    count: int | None = None,
    people: bool = True,
    root: str | Path | None = None,
    every: float = EVERY,
    vehicles: int = 1,
    assets: str = Assets.ALL,
) -> LoopScenes:
    """The scenes that a name or a folder stands for.

    Args:
        source: ``drives``: procedural drives on the world's own road; ``layouts``: procedural
            scenes on the thesis' straight lanes, movers at constant velocity;
            ``mixed_contested``: those of them in which a blind car drives unsafely and one that
            sees drives safely; ``kitti_contested``: the same of the labels in `kitti`;
            ``kitti_tracking`` or ``kitti_raw``: windows of the recordings under `root`, on a
            corridor along the recorded car's path; a folder of labelled scenarios, of KITTI labels
            or of the KITTI object data, as ``layouts``; or a folder of CommonRoad files, on their
            own roads.
        kitti: Root of the KITTI object data, for a list of ids; any folder of labels, for
            ``kitti_contested``.
        seed: Seed of speeds, layouts and drives.
        count: Number of scenes; None: all (200 layouts, 100 drives).
        people: Whether pedestrians and cyclists are there.
        root: Root of the KITTI tracking benchmark or of KITTI raw, for recordings.
        every: Seconds from the start of one window of a recording to the next.
        vehicles: The number of vehicles with sensors in procedural drives: the car, and those that
            share their scans with it.
        assets: The part of the assets that procedural drives are made of, of
            `avsec_gym.world.assets.Assets`: ``train``, ``judge`` or ``all``.  No detector was
            trained on cars of ``judge``.

    Raises:
        ConfigurationError: The name is mistyped, recordings have no root, or a root or `every`
            or `vehicles` or `assets` is given for others.
        DataError: A folder or file is missing or broken.
    """
    if vehicles != 1 and str(source) != DRIVES:
        raise ConfigurationError(f"vehicles is for {DRIVES}, not for {source}")
    part = Assets(one_of("part of the assets", assets, Assets))
    if part != Assets.ALL and str(source) != DRIVES:
        raise ConfigurationError(f"assets is for {DRIVES}, not for {source}")
    if source in (KITTI_TRACKING, KITTI_RAW):
        from avsec_gym.closed_loop.recorded.recorded_scenes import recorded_scenes

        if root is None:
            raise ConfigurationError(
                f'{source} needs the folder of its data: {{"source": "{source}", "root": FOLDER}}'
            )
        found = recorded_scenes(str(source), root, every=every, count=count, people=people)
        return LoopScenes(tuple(found), lambda id: found[id]())
    if root is not None or every != EVERY:
        raise ConfigurationError(
            f"root and every are for {KITTI_TRACKING} and {KITTI_RAW}, not for {source}"
        )
    if str(source) == DRIVES:
        from avsec_gym.closed_loop.procedural_drives import drive_prefix, procedural_drive

        vehicles = whole_number("vehicles", vehicles, 1, _MOST_VEHICLES)
        prefix = drive_prefix(seed, vehicles, part)
        drives = _DRIVES_COUNT if count is None else whole_number("count", count, 1, MOST_LAYOUTS)
        ids = tuple(f"{prefix}-{i:06d}" for i in range(drives))
        return LoopScenes(
            ids,
            lambda id: procedural_drive(
                seed, int(id.rpartition("-")[2]), people=people, vehicles=vehicles, assets=part
            ),
        )
    if is_folder(Path(source) / "training"):
        data = frame_scenes(source, seed=seed, count=count)
        return scenes_to_drive_in(data.scenes, people=people)
    return scenes_to_drive_in(scene_set(source, kitti=kitti, seed=seed, count=count), people=people)


def scenes_to_drive_in(scenes: SceneSet, *, people: bool = True) -> LoopScenes:
    """A set of scenes of the single query, to drive in.

    Args:
        scenes: The set.
        people: Whether pedestrians and cyclists are there.
    """
    by_id = {scene.id: scene for scene in scenes.scenes}

    def make(id: str) -> TrafficScene:
        scene: Scene | GivenScene = by_id[id]
        if isinstance(scene, GivenScene):
            return scene_of_commonroad(scene)
        return scene_on_straight_lanes(scene, people=people)

    return LoopScenes(tuple(by_id), make)
