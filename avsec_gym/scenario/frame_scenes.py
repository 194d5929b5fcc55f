"""Scenes with their sensors: what detectors look at, and what is really there.

Any folder in KITTI's object layout.  Procedural data sets say beside the labels who moves
(``moving/``) and what kind of road it is (``road_type.csv``); without these everything stands, on
a street.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.scenario.label_list import ROAD_TYPES, read_label_list
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_sets import SceneSet, labelled_scene

_SUITES = ("street", "highway", "mixed")


@dataclass(frozen=True, eq=False)
class FrameScenes:
    """Scenes in order of their ids, and the sensor data of each."""

    data: KittiObject
    scenes: SceneSet

    def __len__(self) -> int:
        return len(self.scenes)

    def frame(self, scene: Scene) -> SensorFrame:
        """What the sensors deliver in a scene.

        Raises:
            DataError: The calibration is missing or broken.
        """
        return self.data.frame(scene.id)


def frame_scenes(
    source: str | Path = "mixed",
    *,
    split: str | None = None,
    count: int | None = None,
    seed: int = 0,
) -> FrameScenes:
    """Labelled stereo frames as scenes.

    Args:
        source: ``mixed``, ``street`` or ``highway``: the default suite of that name, made in the
            cache on first use; or a folder in KITTI's object layout.
        split: Such as ``val``; all frames with labels and both images if None.
        count: How many at most.
        seed: Moving objects draw their speeds from it.

    Raises:
        ConfigurationError: The source is neither.
        DataError: A file is missing or broken, or there is no frame with labels and both images.
    """
    data = _data(source)
    ids = data.ids(split, having=("label_2", "image_2", "image_3"))[:count]
    if not ids:
        raise DataError(
            "No frame here has labels and both images.",
            path=data.folder,
            remedy="label_2/, image_2/ and image_3/ need files of the same names.",
        )
    listed = data.folder / "road_type.csv"
    labels = read_label_list(listed) if listed.is_file() else {}
    scenes, remarks = [], []
    for id in ids:
        flags = data.folder / "moving" / f"{id}.txt"
        road_type = ROAD_TYPES[labels.get(id, 1)]
        scene, remark = labelled_scene(
            data.folder / "label_2" / f"{id}.txt",
            flags if flags.is_file() else None,
            road_type,
            seed,
            str(road_type),
        )
        scenes.append(scene)
        remarks += remark
    return FrameScenes(data, SceneSet(str(source), tuple(scenes), tuple(remarks)))


def _data(source: str | Path) -> KittiObject:
    if str(source) in _SUITES:
        from avsec_gym.world.export import world_frames

        return world_frames(str(source))
    if not Path(source).is_dir():
        raise ConfigurationError(
            f"there are no labelled frames {str(source)!r}: name a folder in KITTI's object layout,"
            f" or a default suite ({', '.join(_SUITES)})"
        )
    return KittiObject(source)
