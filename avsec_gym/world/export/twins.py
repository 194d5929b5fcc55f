"""Digital twins of labelled KITTI frames, in the object layout under the same ids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.label_folders import check_id
from avsec_gym.kitti.sensor_files import read_image_size
from avsec_gym.rig import KITTI_SIZE, SensorRig
from avsec_gym.road_type import RoadType
from avsec_gym.world.assets import Assets
from avsec_gym.world.capture import Capture, render
from avsec_gym.world.export.frame_files import write_object_files
from avsec_gym.world.export.recipe import Sensors
from avsec_gym.world.export.suites import write_lists
from avsec_gym.world.posed_scenes import posed_scene_of_labels
from avsec_gym.world.rendering.lidar import Lidar
from avsec_gym.world.site import Style

_CAMERA_HEIGHT, _HEIGHTS = 1.65, (1.60, 1.72)
_NEAR, _FEWEST = 22.0, 2
_IDS = 1_000_000


@dataclass(frozen=True, eq=False)
class Twins:
    """A rendered frame for each real one: its objects at their poses and sizes, its calibration.

    Args:
        kitti: Root of the real data, of which labels and calibration are read, and the size of
            the left image where it is there.
        ids: Ids of the frames.
        seed: Seed of what labels leave open.
        style: Style of all places; drawn to suit each frame if None.
        road_type: Road type of all places; street if None.
        cameras: Numbers of the cameras that are written.
        lidar: Whether scans are written.
        assets: The part of the assets that all places and actors are made of.

    Raises:
        ConfigurationError: An id is none or stands twice, or a camera is not one of 0 to 3.
    """

    kitti: Path
    ids: tuple[str, ...]
    seed: int = 0
    style: Style | None = None
    road_type: RoadType | None = None
    cameras: tuple[int, ...] = (2, 3)
    lidar: bool = True
    assets: Assets = Assets.ALL
    last_files: str = field(default="training/label_2/*.txt", init=False)

    def __post_init__(self) -> None:
        for id in self.ids:
            check_id(id)
        if len(set(self.ids)) < len(self.ids):
            raise ConfigurationError("an id stands twice")
        Sensors(self.cameras)  # Refuses cameras that KITTI lacks.

    @property
    def settings(self) -> dict[str, Any]:
        """See `Recipe`."""
        return {
            "suite": "twin",
            "seed": self.seed,
            "assets": str(self.assets),
            "style": self.style,
            "road_type": self.road_type,
            "cameras": list(self.cameras),
            "lidar": self.lidar,
        }

    def __len__(self) -> int:
        return len(self.ids)

    def last_file(self, number: int) -> str:
        """See `Recipe`."""
        return f"training/label_2/{self.ids[number]}.txt"

    def make(self, root: Path, number: int) -> list[str]:
        """See `Recipe`; remarks on objects that are hidden in the twin."""
        id, data = self.ids[number], KittiObject(self.kitti)
        try:
            boxes = data.labels(id)
            rig = twin_rig(data, id, boxes)
        except DataError as error:
            return [f"left out: {error}"]
        posed = posed_scene_of_labels(
            boxes,
            rig,
            seed=self.seed * _IDS + int(id),
            road_type=self.road_type,
            style=self.style,
            assets=self.assets,
        )
        capture = render(posed, cameras=self.cameras, lidar=Lidar() if self.lidar else None)
        capture, hidden = _in_the_order_of(boxes, capture)
        notes = {"twin_of": id, "hidden": hidden}
        write_object_files(root / "training", id, posed, capture, notes=notes)
        names = ", ".join(f"{boxes.category[line]} (object {line + 1})" for line in hidden)
        return [f"{id}: not seen in the twin: {names}"] if hidden else []

    def finish(self, root: Path) -> None:
        """See `Recipe`."""
        write_lists(root)


def twin_rig(data: KittiObject, id: str, boxes: Boxes3D) -> SensorRig:
    """The rig of a real frame: its calibration, its image's size, a height from its labels."""
    image = data.folder / "image_2" / f"{id}.png"
    size = read_image_size(image) if image.is_file() else KITTI_SIZE
    return SensorRig(data.calibration(id), size, _camera_height(boxes))


def _camera_height(boxes: Boxes3D) -> float:
    """Above the bottoms of the objects close by; KITTI's where there are few."""
    near = np.hypot(boxes.location[:, 0], boxes.location[:, 2]) < _NEAR
    if near.sum() < _FEWEST:
        return _CAMERA_HEIGHT
    return float(np.clip(np.median(boxes.location[near, 1]), *_HEIGHTS))


def _in_the_order_of(boxes: Boxes3D, capture: Capture) -> tuple[Capture, list[int]]:
    """Labels in the order of the real ones, with their very boxes; which of those are hidden.

    Actor i + 1 is real object i.
    """
    labels = capture.labels
    # Others that are labelled, if any, come after the real ones.
    order = np.argsort(labels.actor, kind="stable")
    actor, seen = labels.actor[order], labels.boxes[order]
    real = actor <= len(boxes)
    location, dimensions = seen.location.copy(), seen.dimensions.copy()
    rotation_y = seen.rotation_y.copy()
    location[real] = boxes.location[actor[real] - 1]
    dimensions[real] = boxes.dimensions[actor[real] - 1]
    rotation_y[real] = boxes.rotation_y[actor[real] - 1]
    exact = replace(seen, location=location, dimensions=dimensions, rotation_y=rotation_y)
    hidden = sorted(set(range(len(boxes))) - set((actor[real] - 1).tolist()))
    return replace(capture, labels=labels._replace(boxes=exact, actor=actor)), hidden


def twin_ids(data: KittiObject, ids: Sequence[str], split: str | None) -> tuple[str, ...]:
    """The frames asked for: by name, of a split, or all that have label and calibration.

    Raises:
        ConfigurationError: Both names and a split are given, or a frame is not there.
        DataError: No frame is.
    """
    if ids and split is not None:
        raise ConfigurationError("name frames with --ids, or a --split, not both")
    there = data.ids(split, having=("label_2", "calib"))
    if not there:
        raise DataError("No frame has both label and calibration.", path=data.folder)
    if not ids:
        return tuple(there)
    missing = [id for id in map(check_id, ids) if id not in set(there)]
    if missing:
        raise ConfigurationError(
            f"{data.folder} has no label and calibration of {', '.join(missing)}"
        )
    return tuple(ids)
