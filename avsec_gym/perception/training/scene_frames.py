"""Frames of the procedural world with the truth of their scenes, on which both classifiers learn.

They come from `avsec world make`: object layout (with ``--previous``, for the frames before) or
raw drives.  The truth, which objects move and on what type of road, is that of the scene files,
which real KITTI lacks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.labels import read_labels
from avsec_gym.kitti.layouts import KittiLayout, recognise
from avsec_gym.kitti.raw import Drive, KittiRaw
from avsec_gym.road_type import RoadType
from avsec_gym.world.export import read_manifest, read_scene_file

_REMEDY = "`avsec world make --suite mixed --previous 3` or `--suite raw` makes such data."
_VALIDATION = 4
"""Every fourth drive is for validation, as is every fourth frame of the object layout."""


@dataclass(frozen=True)
class SceneFrame:
    """A frame with its labels and its scene file; images are loaded when asked for.

    Args:
        source: The folder, or the drive, that the frame belongs to.
        id: The frame's id in its source.
        scene: The name of its place and time: frames of one scene resemble each other.
        left: The file of the left image.
        labels: The file of the labels.
        facts: The scene file.
    """

    source: KittiObject | Drive
    id: str
    scene: str
    left: Path
    labels: Path
    facts: Path

    def frame(self) -> SensorFrame:
        """All sensors, with the frames before."""
        if isinstance(self.source, Drive):
            return self.source.frame(int(self.id))
        return self.source.frame(self.id)

    @property
    def road_type(self) -> RoadType:
        """The type of the road, as the scene file states it."""
        return RoadType(read_scene_file(self.facts, remedy=_REMEDY)["road_type"])

    def boxes(self) -> Boxes3D:
        """The labelled objects, `moving` set.

        Raises:
            DataError: A file is broken, or labels and scene do not belong together.
        """
        objects = read_scene_file(self.facts, remedy=_REMEDY)["objects"]
        boxes = read_labels(self.labels)
        if len(objects) != len(boxes):
            raise DataError(
                f"The scene has {len(objects)} objects, the labels {len(boxes)}.",
                path=self.facts,
                remedy=_REMEDY,
            )
        return replace(boxes, moving=np.array([fact["moving"] for fact in objects], bool))


@dataclass(frozen=True)
class SceneSplit:
    """What a classifier learns from, and what it is validated on: other scenes.

    Args:
        training: The frames to learn from.
        validation: Frames of other scenes.
        roots: The folders of the data.
    """

    training: tuple[SceneFrame, ...]
    validation: tuple[SceneFrame, ...]
    roots: tuple[Path, ...]

    def description(self) -> dict[str, Any]:
        """JSON-able: how the data were made, and how many there are."""
        return {
            "sources": [_described(root) for root in self.roots],
            "training": _counted(self.training),
            "validation": _counted(self.validation),
        }


def split_by_scene(roots: Sequence[Path], validation: Sequence[Path] = ()) -> SceneSplit:
    """The frames of folders, of which some scenes are held out.

    Args:
        roots: The folders, each in the object layout (frames of ``ImageSets/val.txt`` are for
            validation) or the raw layout (every fourth drive is).
        validation: Folders whose frames are all validated on; all frames of `roots` are then
            learned from.

    Raises:
        DataError: A folder is not there, or has no frame with image, labels and scene file.
    """
    if validation:
        return SceneSplit(
            tuple(frame for root in roots for frame in scene_frames(root)),
            tuple(frame for root in validation for frame in scene_frames(root)),
            (*roots, *validation),
        )
    parts = [
        tuple(frame for root in roots for frame in scene_frames(root, split))
        for split in ("train", "val")
    ]
    if not all(parts):
        raise DataError(
            "There are too few scenes to hold some out for validation.",
            path=roots[0],
            remedy="Make more of them, or name others by --validation.",
        )
    return SceneSplit(parts[0], parts[1], tuple(roots))


def scene_frames(root: Path, split: str | None = None) -> list[SceneFrame]:
    """The frames of a folder.

    Args:
        root: The folder, in the object or the raw layout.
        split: The split, ``train`` or ``val``; all if None.

    Raises:
        DataError: The folder is not there, or has no frame with image, labels and scene file.
    """
    if recognise(root) == KittiLayout.RAW:
        found = _of_drives(root, split)
    else:
        data = KittiObject(root)
        found = [
            _of_folder(data, id, f"{data.folder}:{id}", data.folder)
            for id in data.ids(split, ("image_2", "label_2", "calib"))
        ]
    there = [frame for frame in found if frame.facts.is_file()]
    if not there and split is None:
        raise DataError(
            "No frame here has an image, labels and a scene file.", path=root, remedy=_REMEDY
        )
    return there


def _of_drives(root: Path, split: str | None) -> list[SceneFrame]:
    raw, found = KittiRaw(root), []
    for index, name in enumerate(raw.drives()):
        is_held_out = index % _VALIDATION == _VALIDATION - 1
        if split is None or (split == "val") == is_held_out:
            drive = raw.drive(name)
            found += [_of_drive(drive, number) for number in drive.frames(["image_02"])]
    return found


def _of_folder(data: KittiObject, id: str, scene: str, folder: Path) -> SceneFrame:
    return SceneFrame(
        data,
        id,
        scene,
        folder / "image_2" / f"{id}.png",
        folder / "label_2" / f"{id}.txt",
        folder / "scene" / f"{id}.json",
    )


def _of_drive(drive: Drive, number: int) -> SceneFrame:
    folder, id = drive.folder, f"{number:010d}"
    return SceneFrame(
        drive,
        id,
        str(folder),
        drive.path("image_02", number),
        folder / "label_02" / "data" / f"{id}.txt",
        folder / "scene_02" / "data" / f"{id}.json",
    )


def _described(root: Path) -> dict[str, Any]:
    manifest = read_manifest(root) or {}
    return {
        "name": root.name,
        "settings": manifest.get("settings"),
        "fingerprint": manifest.get("fingerprint"),
    }


def _counted(frames: Sequence[SceneFrame]) -> dict[str, int]:
    return {"frames": len(frames), "scenes": len({frame.scene for frame in frames})}
