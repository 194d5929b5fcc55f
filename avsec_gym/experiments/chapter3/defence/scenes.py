"""What is really there at a frame of a raw drive: its scene."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.raw import Drive
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_sets import labelled_scene
from avsec_gym.world.export import read_scene_file


def scene_of(frame: SensorFrame, id: str, number: int, seed: int = 0) -> Scene:
    """The scene of a frame.

    A procedural drive has labels, moving flags and the road type of every frame.  Of a real one
    the tracklets are taken, which hold where things are, but not that they move: all stand, on a
    street.

    Args:
        frame: A frame of a drive, as its reader gives it.
        id: The id of the scene; frames of several drives have the same numbers.
        number: The number of the scene, see `Scene`.
        seed: The seed of the scene, see `Scene`.

    Raises:
        DataError: The drive has neither labels nor tracklets, or a file is broken.
    """
    if frame.origin is None:
        raise DataError(
            f"Frame {frame.id} does not come from a drive: what is there is unknown.",
            remedy="Read it with KittiRaw(root).drive(name).frame(number).",
        )
    labels = _place(frame.origin, "label", f"{frame.id}.txt")
    if not labels.is_file():
        boxes = Drive(frame.origin).labels(int(frame.id))
        standing = replace(boxes, moving=np.zeros(len(boxes), bool))
        return Scene(id, standing, RoadType.STREET, seed, number)
    flags = _place(frame.origin, "moving", f"{frame.id}.txt")
    about = _place(frame.origin, "scene", f"{frame.id}.json")
    road_type = RoadType(read_scene_file(about, remedy="Make the drive anew.")["road_type"])
    scene, _ = labelled_scene(labels, flags, road_type, seed, str(road_type))
    return replace(scene, id=id, number=number)


def _place(drive: Path, kind: str, name: str) -> Path:
    return drive / f"{kind}_02" / "data" / name
