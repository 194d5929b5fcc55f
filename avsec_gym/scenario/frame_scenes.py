"""Scenes with what the sensors deliver in them: labelled stereo frames in KITTI's object layout.

The procedural world writes which objects move (``moving/``) and the road type (``road_type.csv``)
beside its labels; frames without these, such as real ones, are taken to stand still on a street,
unless the labelled scenarios of the thesis' authors hold more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import one_of
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.map_files import read_disparity
from avsec_gym.scenario.contested_sets import ENTRY_POINT, contested_sets
from avsec_gym.scenario.label_list import ROAD_TYPES, read_label_list
from avsec_gym.scenario.roads import THESIS, no_road_of_its_own, on_own_roads
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_arguments import scene_arguments
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import MIXED_CONTESTED, labelled_scenarios, labelled_scene
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.regular_files import is_file, is_folder
from avsec_gym.suggestions import unknown_name
from avsec_gym.unknown_source import unknown_source
from avsec_gym.world.assets import Assets

_SPLITS = ("train", "val", "trainval")
_SUITE_FRAMES = {"street": 24, "highway": 24, "mixed": 48}
SUITES = tuple(_SUITE_FRAMES)
"""Names of the procedural world's own; those of a part of the assets have as many frames."""
_SUITE_SENSORS = frozenset[Sensor]((LIDAR, 2, 3))


@dataclass(frozen=True, eq=False)
class FrameScenes:
    """Scenes in order of their ids, and the sensor data of each.

    Args:
        scenes: The scenes that were chosen.
        data: Data set that holds the frame of each scene, by the scene's id.
    """

    scenes: SceneSet
    data: Mapping[str, KittiObject]

    def __len__(self) -> int:
        return len(self.scenes)

    def frame(self, scene: Scene) -> SensorFrame:
        """What the sensors deliver in a scene.

        Raises:
            DataError: The calibration is missing or broken.
        """
        data = self.data[scene.id]
        frame = data.frame(scene.id)
        if not data.folder.resolve().parent.name.startswith("vehicle_"):
            return frame
        # One of several connected vehicles: what the others share stands beside the frame.
        from avsec_gym.world.export import neighbours_of

        return replace(frame, neighbours=neighbours_of(data, scene.id))

    def labels(self, scene: Scene) -> Boxes3D:
        """What is to be seen in the images, with the regions not to care about.

        Raises:
            DataError: The file is missing or broken.
        """
        return self.data[scene.id].labels(scene.id, keep_dont_care=True)

    def disparity(self, scene: Scene) -> NDArray[np.float32] | None:
        """True disparity of the left image, pixels, 0 where unknown, (H, W); None without any.

        Raises:
            DataError: The file is broken.
        """
        path = self.data[scene.id].folder / "disparity_2" / f"{scene.id}.png"
        return np.nan_to_num(read_disparity(path)) if path.is_file() else None


def frame_scenes(
    source: str | Path | Sequence[str | Path] = "mixed",
    *,
    scenarios: str | Path | None = None,
    split: str | None = None,
    count: int | None = None,
    seed: int = 0,
    contested: bool = False,
    assets: str = Assets.ALL,
) -> FrameScenes:
    """Labelled stereo frames as scenes.

    Args:
        source: ``mixed``, ``street`` or ``highway``: the default suite of that name, made in the
            cache on first use; ``mixed_contested``: one of contested scenes; or one folder or
            several in KITTI's object layout.
        scenarios: The authors' labelled scenarios; those with a frame in a source are the scenes,
            as their own labels and flags state.
        split: Name of a split, such as ``val``; all frames with labels and both images if None.
        count: Largest number of scenes.
        seed: Seed of the speeds of moving objects.
        contested: Whether only contested scenes are taken; see `avsec_gym.evaluation.contested`.
        assets: The part of the assets that suites are made of, of `avsec_gym.world.assets.Assets`:
            ``train``, ``judge`` or ``all``.  Layouts are the same in each.  No detector was
            trained on cars of ``judge``.

    Raises:
        ConfigurationError: A source is a mistyped name, no scene is contested, or a part of the
            assets is asked for of what is made already.
        DataError: A folder or file is missing or broken, or there is no frame with labels and both
            images.
    """
    sources = [source] if isinstance(source, str | Path) else source
    part = _known_part(sources, assets)
    data: dict[str, KittiObject] = {}
    for kitti in (_data(each, part) for each in sources):
        data |= dict.fromkeys(kitti.ids(split, having=("label_2", "image_2", "image_3")), kitti)
    if not data:
        raise DataError(
            "No frame here has labels and both images.",
            path=Path(str(sources[0])),
            remedy="label_2/, image_2/ and image_3/ need files of the same names.",
        )
    contested = contested or MIXED_CONTESTED in map(str, sources)
    first = None if contested else count
    scenes = _given(scenarios, data, seed) if scenarios else _labelled(sources, data, first, seed)
    if contested:
        scenes = contested_sets().contested(scenes)
    return FrameScenes(scenes.limited(count), data)


def frame_scenes_of(what: Any, road: str = THESIS) -> FrameScenes:
    """Scenes that are named: the form in which environments ask for them, and keep them.

    Args:
        what: A source, a dictionary of arguments of `frame_scenes`, or live scenes.
        road: The road that they are driven on, one of `avsec_gym.scenario.roads.ROADS`.

    Raises:
        ConfigurationError: These are no arguments, a source is none, or a scene has no road of its
            own that is asked for.
        DataError: See `frame_scenes`.
    """
    if isinstance(what, FrameScenes):
        scenes = what
    else:
        check_frame_scenes(what, road)
        scenes = _kept(tuple(sorted(scene_arguments(what, frame_scenes).items())))
    return scenes if road == THESIS else _on_own_roads(scenes)


def check_frame_scenes(what: Any, road: str = THESIS) -> None:
    """Refuse what `frame_scenes_of` cannot know, without making a suite or reading a scene.

    Args:
        what: A source, a dictionary of arguments or live scenes, as of `frame_scenes_of`.
        road: The road that they are driven on, as of `frame_scenes_of`.

    Raises:
        ConfigurationError: These are no arguments, a source or split is a mistyped name, or a
            folder's scenes have no road of their own that is asked for.
        DataError: A folder or split is missing.
    """
    if isinstance(what, FrameScenes):
        return
    asked = scene_arguments(what, frame_scenes)
    source, split = asked.get("source", "mixed"), asked.get("split")
    _known_part([source] if isinstance(source, str) else source, asked.get("assets", Assets.ALL))
    labelled = asked.get("scenarios")
    if labelled is not None and not is_folder(labelled):
        raise DataError(
            "There is no such folder.",
            path=labelled,
            remedy="Name the folder of the labelled scenarios.",
        )
    for each in source if isinstance(source, tuple) else [source]:
        if str(each) not in (*SUITES, MIXED_CONTESTED):
            data = _data(str(each))
            _ = split is None or data.ids(split)  # Which looks into the list of them only.
            if road != THESIS and not is_folder(data.folder / "scene"):
                raise no_road_of_its_own(f"what lies in {each}")
        elif split not in (None, *_SPLITS):
            problem = f"the suite {each} has no split {split!r}"
            raise ConfigurationError(unknown_name(problem, str(split), _SPLITS))


def sensors_of(what: Any) -> frozenset[Sensor]:
    """The sensors of some of the frames; no suite is made for it, and no frame is read.

    Args:
        what: A source, a dictionary of arguments or live scenes, as `check_frame_scenes` accepts.
    """
    if isinstance(what, FrameScenes):
        return frozenset().union(*(data.sensors for data in set(what.data.values())))
    source = scene_arguments(what, frame_scenes).get("source", "mixed")
    sources = map(str, source if isinstance(source, tuple) else [source])
    return frozenset().union(
        *(
            _SUITE_SENSORS if each in (*SUITES, MIXED_CONTESTED) else _data(each).sensors
            for each in sources
        )
    )


@lru_cache(maxsize=8)
def _kept(arguments: tuple[tuple[str, Any], ...]) -> FrameScenes:
    return frame_scenes(**dict(arguments))


def _on_own_roads(scenes: FrameScenes) -> FrameScenes:
    """The same, on the roads of the layouts that the scene files name."""
    layouts = {}
    for scene in scenes.scenes.labelled:
        path = scenes.data[scene.id].folder / "scene" / f"{scene.id}.json"
        if is_file(path):
            facts = read_json_object(path, remedy="Make the frame anew with `avsec world make`.")
            layouts[scene.id] = str(facts.get("layout"))
    return replace(scenes, scenes=on_own_roads(scenes.scenes, layouts))


def _given(scenarios: str | Path, data: Mapping[str, KittiObject], seed: int) -> SceneSet:
    every = labelled_scenarios(scenarios, seed=seed)
    scenes = tuple(scene for scene in every.scenes if scene.id in data)
    if not scenes:
        raise DataError(
            "None of these scenarios has a frame with both images in the given data.",
            path=Path(scenarios),
            remedy="`avsec world twin` renders frames for them.",
        )
    missing = len(every) - len(scenes)
    remarks = (f"{missing} of {len(every)} scenarios have no images",) if missing else ()
    return replace(every, scenes=scenes, remarks=(*every.remarks, *remarks))


def _labelled(
    sources: Sequence[str | Path], data: Mapping[str, KittiObject], count: int | None, seed: int
) -> SceneSet:
    lists = {kitti.folder: kitti.folder / "road_type.csv" for kitti in data.values()}
    road_types = {
        folder: read_label_list(path) if path.is_file() else {} for folder, path in lists.items()
    }
    scenes, remarks = [], []
    for id in sorted(data)[:count]:
        folder = data[id].folder
        flags = folder / "moving" / f"{id}.txt"
        road_type = ROAD_TYPES[road_types[folder].get(id, 1)]
        scene, remark = labelled_scene(
            folder / "label_2" / f"{id}.txt",
            flags if flags.is_file() else None,
            road_type,
            seed,
            str(road_type),
        )
        scenes.append(scene)
        remarks += remark
    return SceneSet(" ".join(map(str, sources)), tuple(scenes), tuple(remarks))


def _known_part(sources: Sequence[str | Path], assets: str) -> Assets:
    """The part of the assets that sources are made of.

    Raises:
        ConfigurationError: There is no such part, or a source is made already.
    """
    part = Assets(one_of("part of the assets", assets, Assets))
    for source in sources:
        if part != Assets.ALL and str(source) not in (*SUITES, MIXED_CONTESTED):
            raise ConfigurationError(
                f"assets is for the suites {', '.join((*SUITES, MIXED_CONTESTED))}, not for"
                f" {source}: `avsec world make --assets` makes a folder of a part"
            )
    return part


def _suite(name: str, assets: Assets) -> KittiObject:
    """A default suite; one of a part of the assets stands beside it in the cache."""
    from avsec_gym.world.export import cached, suite_recipe, world_frames

    if assets == Assets.ALL:
        return world_frames(name)
    recipe = suite_recipe(name, _SUITE_FRAMES[name], previous=0, assets=assets)
    return KittiObject(cached(f"{name}-{assets}", recipe))


def _contested_suite(assets: Assets) -> KittiObject:
    """The suite of contested scenes; one of a part of the assets stands beside it in the cache."""
    from avsec_gym.world.export import cached

    if assets == Assets.ALL:
        return KittiObject(contested_sets().contested_frames())
    chosen = import_module(ENTRY_POINT)
    recipe = chosen.contested_recipe(chosen.FRAMES, assets=assets)
    return KittiObject(cached(f"{MIXED_CONTESTED}-{assets}", recipe))


def _data(source: str | Path, assets: Assets = Assets.ALL) -> KittiObject:
    if str(source) in SUITES:
        return _suite(str(source), assets)
    if str(source) == MIXED_CONTESTED:
        return _contested_suite(assets)
    if not is_folder(source):
        suites = (*SUITES, MIXED_CONTESTED)
        raise unknown_source(
            str(source),
            suites,
            "Name a folder in KITTI's object layout with labels and both images, or a default"
            f" suite ({', '.join(suites)}).",
        )
    return KittiObject(source)
