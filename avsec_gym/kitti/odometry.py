"""The KITTI odometry benchmark where the user has it: long sequences with poses, without labels."""

from __future__ import annotations

import re
from functools import cached_property
from pathlib import Path

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats
from avsec_gym.kitti.calibration import read_odometry_calibration
from avsec_gym.kitti.number_tables import read_numbers
from avsec_gym.kitti.recording import Recording, check_sequence, frame_numbers, subfolders
from avsec_gym.storage.regular_files import is_file, is_folder

SEQUENCES, POSES, VELODYNE = "sequences", "poses", "velodyne"
"""What the folder of the benchmark holds; the scans of a sequence."""
CALIBRATION, TIMES = "calib.txt", "times.txt"
"""Calibration and times of a sequence."""

_SEQUENCE = re.compile(r"[0-9]{2}")
_SENSORS = re.compile(r"image_[0-9]|velodyne")
_DIGITS = 6
_DOWNLOAD = "Fetch it with the odometry benchmark and put it beside the others"


class KittiOdometry:
    """The official layout: ``dataset/`` with ``sequences/00/image_2/`` and ``poses/00.txt``...

    Args:
        root: The folder that holds ``sequences/``, or the one above it.

    Raises:
        DataError: Nothing of the layout is there.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root)
        folder = odometry_folder(self.root)
        if folder is None:
            raise DataError(
                "Nothing of the KITTI odometry layout is here."
                if is_folder(self.root)
                else "There is no such folder.",
                path=self.root,
                remedy="Name the folder that holds sequences/ with 00/, 01/ and so on; `avsec data "
                "check` lists what a folder holds.",
            )
        self.folder = folder

    def sequences(self) -> list[str]:
        """Names such as ``00``, sorted."""
        return list(subfolders(self.folder / SEQUENCES, _SEQUENCE))

    def sequence(self, name: str) -> OdometrySequence:
        """A sequence.

        Raises:
            DataError: There is no such sequence.
        """
        check_sequence(name, self.sequences(), self.folder)
        return OdometrySequence(self.folder, name)


class OdometrySequence(Recording):
    """One sequence; any part may be absent until it is asked for.

    Args:
        folder: The folder that holds ``sequences/`` and ``poses/``.
        name: Two digits, the sequence's name.
    """

    def __init__(self, folder: str | Path, name: str) -> None:
        own = Path(folder) / SEQUENCES / name
        super().__init__(own, name, f"sequence {name}", _DOWNLOAD)

    def __repr__(self) -> str:
        return f"OdometrySequence({str(self.folder.parent.parent)!r}, {self.name!r})"

    @cached_property
    def sensors(self) -> dict[str, tuple[int, ...]]:
        """The numbers of the frames of ``image_0`` to ``image_3`` and ``velodyne``."""
        numbers = {
            sensor: frame_numbers(folder, _DIGITS, _suffix(sensor))
            for sensor, folder in subfolders(self.folder, _SENSORS).items()
        }
        return {sensor: there for sensor, there in numbers.items() if there}

    @property
    def scanner(self) -> str:
        """The folder of the LiDAR's scans."""
        return VELODYNE

    def path(self, sensor: str, number: int) -> Path:
        """The file of a frame, whether or not it is there."""
        return self.folder / sensor / f"{self.frame_id(number)}{_suffix(sensor)}"

    def image_folder(self, camera: int) -> str:
        """The folder of a camera's images."""
        return f"image_{camera}"

    def frame_id(self, number: int) -> str:
        """Six digits."""
        return f"{number:0{_DIGITS}d}"

    @cached_property
    def calibration(self) -> Calibration:
        """Of the sequence; see `read_odometry_calibration`."""
        return read_odometry_calibration(self._file(self.folder / CALIBRATION))

    @cached_property
    def times(self) -> Floats:
        """Seconds since the first frame; element i is frame i.

        Raises:
            DataError: They are not there, or a line is no number.
        """
        return read_numbers(self._file(self.folder / TIMES), 1)[:, 0]

    @cached_property
    def poses(self) -> Floats:
        """From camera 0 (rectified) to its place at frame 0, shape (N, 4, 4); element i is frame i.

        Raises:
            DataError: They are not there (KITTI publishes those of 00 to 10), or a line is broken.
        """
        path = self.folder.parent.parent / POSES / f"{self.name}.txt"
        rows = read_numbers(self._file(path), 12)
        poses = np.tile(np.eye(4), (len(rows), 1, 1))
        poses[:, :3] = rows.reshape(-1, 3, 4)
        return poses

    def _file(self, path: Path) -> Path:
        if not is_file(path):
            raise self._absent(f"{path.parent.name}/{path.name}", self._download)
        return path


def odometry_folder(root: Path) -> Path | None:
    """The folder that holds ``sequences/``: the root, its ``dataset/``, or the one above; or None.

    Args:
        root: A folder of odometry, the one that holds ``dataset/``, or ``sequences/`` itself.
    """
    above = [root.absolute().parent] if root.absolute().name == SEQUENCES else []
    for folder in (root, root / "dataset", *above):
        if subfolders(folder / SEQUENCES, _SEQUENCE):
            return folder
    return None


def _suffix(sensor: str) -> str:
    return ".bin" if sensor == VELODYNE else ".png"
