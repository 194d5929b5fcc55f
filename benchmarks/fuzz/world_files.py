"""What the procedural world writes beside KITTI's layout, and who reads it: the truth of scenes."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import sound_files

FRAME = "000000"
_CARS = (
    "Car 0.00 0 -1.85 733.06 182.54 934.34 317.95 1.45 1.49 3.79 2.73 1.60 9.79 -1.58\n"
    "Van 0.25 1 0.00 10.00 20.00 30.00 40.50 2.00 1.90 5.00 -3.00 1.70 20.00 0.10\n"
)
_SCENE = {
    "road_type": "street",
    "objects": [
        {"category": "Car", "actor": 3, "moving": True, "speed": 4.5},
        {"category": "Van", "actor": 8, "moving": False, "speed": 0.0},
    ],
    "notes": {"layout": "street-000000", "ego_speed": 6.5},
}


def labelled_scene(folder: Path) -> None:
    """A frame of the object layout with labels, images and its scene file."""
    training = folder / "training"
    write: dict[str, Callable[[Path], object]] = {
        "label_2/000000.txt": lambda path: path.write_text(_CARS),
        "calib/000000.txt": lambda path: path.write_text(sound_files.CALIBRATION),
        "image_2/000000.png": sound_files.image,
        "image_3/000000.png": sound_files.image,
        "scene/000000.json": lambda path: path.write_text(json.dumps(_SCENE)),
        "prev_2/000000_01.png": sound_files.image,
    }
    for name, make in write.items():
        (training / name).parent.mkdir(parents=True, exist_ok=True)
        make(training / name)


def read_labelled_scene(folder: Path) -> Any:
    """As the training of the classifiers and the lists of a data set do."""
    from avsec_gym.kitti.dataset import KittiObject
    from avsec_gym.perception.training.scene_frames import SceneFrame
    from avsec_gym.world.export.suites import write_lists

    training = folder / "training"
    place = training / "scene" / f"{FRAME}.json"
    frame = SceneFrame(
        KittiObject(folder), FRAME, "0", training / "image_2" / f"{FRAME}.png",
        training / "label_2" / f"{FRAME}.txt", place,
    )  # fmt: skip
    write_lists(folder)
    return frame.boxes(), str(frame.road_type)


def instant(folder: Path) -> None:
    """Two vehicles, an object, and a frame of one of them with what a detector found."""
    from avsec_gym.world.export.instants import (
        ConnectedInstant,
        SensorVehicle,
        WorldObject,
        write_instant,
    )

    (folder / "objects").mkdir(parents=True)
    vehicles = (SensorVehicle(0, 0.01, 8.0, 0.0), SensorVehicle(4, 0.05, 7.0, 0.1))
    thing = WorldObject(9, "Car", (12.0, 3.0, 0.1), 0.4, (1.5, 1.7, 4.1), 6.0, 0.0, True, (40, 12))
    write_instant(folder / "objects" / f"{FRAME}.json", ConnectedInstant(2, 5, vehicles, (thing,)))
    labelled_scene(folder / "vehicle_0")
    detections = folder / "detections"
    detections.mkdir()
    (detections / f"{FRAME}.txt").write_text(sound_files.DETECTIONS)


def read_instant(folder: Path) -> Any:
    """As connected vehicles and the fit of an error model do."""
    from avsec_gym.closed_loop.error_model.stored_frames import stored_frames
    from avsec_gym.world.export.instants import read_instant, shared_objects

    found = read_instant(folder / "objects" / f"{FRAME}.json")
    shared_objects([found])
    frames = stored_frames(folder / "vehicle_0", folder / "detections")
    return found, [(frame.drive, frame.time, frame.actors) for frame in frames]


def pose(folder: Path) -> None:
    """A vehicle's pose."""
    turned, up = np.pi / 7, 1.73
    numbers = [np.cos(turned), -np.sin(turned), 0, 30.0, np.sin(turned), np.cos(turned), 0, -4.0]
    numbers += [0, 0, 1, up]
    (folder / "pose.txt").write_text(" ".join(f"{number:.9e}" for number in numbers) + "\n")


def read_pose(folder: Path) -> Any:
    """As connected vehicles do."""
    from avsec_gym.world.export.connected_world import read_pose

    return read_pose(folder / "pose.txt")


def drive_with(folder: Path) -> Any:
    """As `avsec drive --scenarios FOLDER` does: a folder of CommonRoad files is driven in."""
    import gymnasium as gym

    import avsec_gym  # noqa: F401
    from avsec_gym.errors import ConfigurationError, DataError, PlanningError

    try:
        environment = gym.make("avsec/ClosedLoop-v0", scenarios={"source": str(folder)})
        environment.reset(seed=0)
        for _ in range(3):
            environment.step(np.zeros(2, np.float32))
    except (ConfigurationError, PlanningError) as error:
        raise DataError(str(error), path=folder / "scenario.xml") from None
    return environment.unwrapped.log().car  # type: ignore[attr-defined]


def commonroad_folder(folder: Path) -> None:
    """A folder with a planning problem of a procedural layout."""
    sound_files.commonroad(folder / "scenario.xml")
