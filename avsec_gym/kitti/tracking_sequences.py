"""The KITTI tracking benchmark where the user has it, complete or in part: sequences of frames."""

from __future__ import annotations

import re
from functools import cached_property
from pathlib import Path

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats
from avsec_gym.kitti.calibration import read_calibration
from avsec_gym.kitti.oxts import Oxts, read_oxts_table
from avsec_gym.kitti.oxts_poses import poses_from_oxts
from avsec_gym.kitti.recording import Recording, check_sequence, frame_numbers, subfolders
from avsec_gym.kitti.tracking import TrackedBoxes, read_tracking_labels
from avsec_gym.storage.regular_files import is_file, is_folder

LABELS, CALIBRATION, VELODYNE, OXTS = "label_02", "calib", "velodyne", "oxts"
"""What a half of the benchmark may hold besides ``image_02`` and ``image_03``."""
FOLDERS = (LABELS, CALIBRATION, "image_02", "image_03", VELODYNE, OXTS)
"""All of it."""

_SEQUENCE = re.compile(r"[0-9]{4}")
_SENSORS = re.compile(r"image_[0-9]{2}|velodyne")
_DIGITS = 6
_DOWNLOAD = "Fetch it with the tracking benchmark and put it beside the others"


class KittiTracking:
    """The official layout: ``training/`` with ``label_02/0000.txt``, ``image_02/0000/``...

    Args:
        root: The folder that holds ``training/``, or a half such as ``training`` itself.

    Raises:
        DataError: Nothing of the layout is there.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root)
        for folder in (self.root / "training", self.root):
            if sequence_names(folder):
                self.folder = folder
                return
        raise DataError(
            "Nothing of the KITTI tracking layout is here."
            if is_folder(self.root)
            else "There is no such folder.",
            path=self.root,
            remedy="Name the folder that holds training/ with label_02/, calib/, image_02/ and so "
            "on; `avsec data check` lists what a folder holds.",
        )

    def sequences(self) -> list[str]:
        """Names such as ``0000``, sorted: all that have anything."""
        return sequence_names(self.folder)

    def sequence(self, name: str) -> TrackingSequence:
        """A sequence.

        Raises:
            DataError: There is no such sequence.
        """
        check_sequence(name, self.sequences(), self.folder)
        return TrackingSequence(self.folder, name)


class TrackingSequence(Recording):
    """One sequence; any part may be absent until it is asked for.

    Args:
        folder: The half that it is in, such as ``training``.
        name: Four digits, the sequence's name.
    """

    def __init__(self, folder: str | Path, name: str) -> None:
        super().__init__(Path(folder), name, f"sequence {name}", _DOWNLOAD)

    def __repr__(self) -> str:
        return f"TrackingSequence({str(self.folder)!r}, {self.name!r})"

    @cached_property
    def sensors(self) -> dict[str, tuple[int, ...]]:
        """The numbers of the frames of ``image_02``, ``image_03`` and ``velodyne``."""
        numbers = {
            sensor: frame_numbers(folder / self.name, _DIGITS, _suffix(sensor))
            for sensor, folder in subfolders(self.folder, _SENSORS).items()
        }
        return {sensor: there for sensor, there in numbers.items() if there}

    @property
    def scanner(self) -> str:
        """The folder of the LiDAR's scans."""
        return VELODYNE

    def path(self, sensor: str, number: int) -> Path:
        """The file of a frame, whether or not it is there."""
        name = f"{self.frame_id(number)}{_suffix(sensor)}"
        return self.folder / sensor / self.name / name

    def frame_id(self, number: int) -> str:
        """Six digits."""
        return f"{number:0{_DIGITS}d}"

    @cached_property
    def calibration(self) -> Calibration:
        """Of the sequence; see `read_calibration`."""
        return read_calibration(self._text(CALIBRATION))

    @cached_property
    def oxts(self) -> Oxts:
        """What the inertial unit measured; element i is frame i.

        Raises:
            DataError: It is not there, or a line is broken.
        """
        return read_oxts_table(self._text(OXTS))

    @cached_property
    def poses(self) -> Floats:
        """From the inertial unit to the world at each frame; see `poses_from_oxts`."""
        return poses_from_oxts(self.oxts)

    @cached_property
    def tracks(self) -> dict[int, TrackedBoxes]:
        """The labelled objects by frame; see `read_tracking_labels`."""
        return read_tracking_labels(self._text(LABELS))

    def labels(self, number: int) -> Boxes3D:
        """The labelled objects of a frame in the camera frame; none where the file names none."""
        if number in self.tracks:
            return self.tracks[number].boxes
        some = next(iter(self.tracks.values()), None)
        return Boxes3D.empty() if some is None else some.boxes[np.zeros(len(some.boxes), bool)]

    def _text(self, kind: str) -> Path:
        path = self.folder / kind / f"{self.name}.txt"
        if not is_file(path):
            raise self._absent(f"{kind}/{self.name}.txt", self._download)
        return path


def sequence_names(folder: Path) -> list[str]:
    """The sequences of a half of the benchmark: all that have a file or a folder in any part.

    Frames of the object benchmark, whose folders are named alike, have six digits instead of four.
    """
    found: set[str] = set()
    for part in subfolders(folder, re.compile("|".join(FOLDERS))).values():
        stems = (path.name.removesuffix(".txt") for path in part.iterdir())
        found.update(stem for stem in stems if _SEQUENCE.fullmatch(stem))
    return sorted(found)


def _suffix(sensor: str) -> str:
    return ".bin" if sensor == VELODYNE else ".png"
