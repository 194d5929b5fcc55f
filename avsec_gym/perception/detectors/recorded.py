"""Detectors that look things up: the truth itself, and what another detector wrote into files."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.argument_checks import label, place
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.image_only import WHAT_IT_IS_FOR, is_image_only
from avsec_gym.kitti.labels import read_detections, read_labels
from avsec_gym.storage.regular_files import is_file, is_folder


class Oracle:
    """The labels of the folder that a frame comes from."""

    name = "oracle"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The truth.

        Raises:
            DataError: The frame comes from no folder, or there is no label file of it.
        """
        if frame.origin is None:
            raise DataError(
                f"Frame {frame.id} does not come from a folder: there are no labels to look up.",
                remedy="Open it with KittiObject(root).frame(id), or use a detector that looks.",
            )
        return read_labels(frame.origin / "label_2" / f"{frame.id}.txt")


class Replayed:
    """A KITTI result folder of any detector.

    Args:
        detections: The folder, with a file for each frame, an empty one where nothing was found.
        name: The name of the detector that wrote it; the folder's if None.

    Raises:
        ConfigurationError: Neither a folder's name nor a detector's.
        DataError: There is no such folder.
    """

    def __init__(self, detections: str | Path, name: str | None = None) -> None:
        self._folder = place("detections", detections)
        if not is_folder(self._folder):
            raise DataError(
                "There is no such folder of detections.",
                path=self._folder,
                remedy="Name a folder of KITTI result files, such as 000107.txt.",
            )
        self.name = self._folder.name if name is None else label("name", name)

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The content of the file of the frame's id.

        Raises:
            DataError: The file is missing or broken, or holds 2D boxes alone, by which no car can
                drive.
        """
        path = self._folder / f"{frame.id}.txt"
        if not is_file(path):
            raise DataError(
                f"Frame {frame.id} has no result file here: what was found is not known.",
                path=path,
                remedy="Replay the results of these very frames; a frame in which nothing was found"
                " has an empty file.",
            )
        found = read_detections(path)
        if is_image_only(found).any():
            raise DataError(
                "Some of these detections have no 3D box: what is known in the image only is"
                " in no car's way.",
                path=path,
                remedy=f"Replay the results of a detector of 3D boxes; {WHAT_IT_IS_FOR}.",
            )
        return found
