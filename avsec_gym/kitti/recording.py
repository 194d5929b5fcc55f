"""What all recordings of KITTI share: numbered frames of several sensors, any of which may lack."""

from __future__ import annotations

import os
import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.frame import Calibration, LazyImages, SensorFrame
from avsec_gym.kitti.sensor_files import ImageFile, ScanFile
from avsec_gym.storage.regular_files import is_folder

_IMAGES = re.compile(r"image_([0-9]{1,2})")


class Recording(ABC):
    """Frames of one drive, or of one sequence of a benchmark; loaded when they are asked for.

    Args:
        folder: The folder that messages name.
        name: The name of the drive or the sequence.
        what: The recording's name there, such as ``drive``.
        download: What brings missing parts, a sentence without its full stop.
    """

    def __init__(self, folder: Path, name: str, what: str, download: str) -> None:
        self.folder, self.name = folder, name
        self._what, self._download = what, download

    @property
    @abstractmethod
    def sensors(self) -> dict[str, tuple[int, ...]]:
        """The numbers of the frames that each sensor has, sorted, by the sensor's folder.

        Sensors without any frame are left out.
        """

    @property
    @abstractmethod
    def scanner(self) -> str:
        """The folder of the LiDAR's scans."""

    @property
    @abstractmethod
    def calibration(self) -> Calibration:
        """Of all frames.

        Raises:
            DataError: It is missing or broken.
        """

    @abstractmethod
    def path(self, sensor: str, number: int) -> Path:
        """The file of a frame, whether or not it is there."""

    @abstractmethod
    def frame_id(self, number: int) -> str:
        """The name of a frame's files, without their suffix."""

    def image_folder(self, camera: int) -> str:
        """The folder of a camera's images."""
        return f"image_{camera:02d}"

    def frames(self, having: Sequence[str] = ()) -> list[int]:
        """Frame numbers, sorted.

        Args:
            having: Folders of sensors, such as ``("image_02", "velodyne_points")``; frames without
                a file in one of them are left out; frames of any sensor if empty.

        Raises:
            DataError: A sensor has none at all.
        """
        for name in having:
            if name not in self.sensors:
                raise self._absent(
                    f"frames of {name}", f"{self._download}, or ask for what is there"
                )
        every = [set(there) for name, there in self.sensors.items() if not having or name in having]
        common = set.intersection if having else set.union
        return sorted(common(*every)) if every else []

    def frame(self, number: int, *, previous: int = 3) -> SensorFrame:
        """All sensors of a frame: every image and scan that is there, loaded on demand.

        Args:
            number: The frame's number.
            previous: Number of earlier frames to look for; those that have an image or a scan
                become its `previous`, the latest first.

        Raises:
            DataError: No sensor has the frame, or the calibration is missing or broken.
        """
        if not any(number in there for there in self.sensors.values()):
            numbers = self.frames()
            span = f"{len(numbers)} from {numbers[0]} to {numbers[-1]}" if numbers else "none"
            raise DataError(
                f"There is no frame {number}.",
                path=self.folder,
                remedy=f"The {self._what} has {span}.",
            )
        before = [self._frame_alone(number - step) for step in range(1, previous + 1)]
        earlier = tuple(frame for frame in before if frame.images or frame.has_points)
        now = self._frame_alone(number)
        return SensorFrame(now.id, now.calibration, now.images, now.scan, earlier, self.folder)

    def _frame_alone(self, number: int) -> SensorFrame:
        images = {
            int(match[1]): ImageFile(self.path(name, number))
            for name, there in self.sensors.items()
            if (match := _IMAGES.fullmatch(name)) and number in there
        }
        has_scan = number in self.sensors.get(self.scanner, ())
        return SensorFrame(
            self.frame_id(number),
            self.calibration,
            LazyImages(images),
            ScanFile(self.path(self.scanner, number)) if has_scan else None,
            origin=self.folder,
        )

    def _absent(self, what: str, remedy: str) -> DataError:
        problem = f"The {self._what} has no {what}."
        return DataError(problem, path=self.folder, remedy=f"{remedy}.")


def check_sequence(name: str, there: Sequence[str], folder: Path) -> None:
    """Refuse a sequence that a data set does not have.

    Args:
        name: The name that was asked for.
        there: The names of those that it has.
        folder: The folder that the message names.

    Raises:
        DataError: There is no such sequence.
    """
    if name not in there:
        raise DataError(
            f"There is no sequence {name}.",
            path=folder,
            remedy=f"There are {', '.join(there) or 'none'}.",
        )


def frame_numbers(folder: Path, digits: int, suffix: str) -> tuple[int, ...]:
    """Sorted numbers of the files in a folder that are named by so many digits and the suffix."""
    name = re.compile(rf"([0-9]{{{digits}}}){re.escape(suffix)}")
    every = os.listdir(folder) if is_folder(folder) else ()
    return tuple(sorted(int(match[1]) for file in every if (match := name.fullmatch(file))))


def subfolders(folder: Path, pattern: re.Pattern[str]) -> dict[str, Path]:
    """The folders in a folder whose whole name fits a pattern, by name, sorted."""
    try:
        children = sorted(folder.iterdir())
    except (OSError, ValueError):
        return {}
    return {
        path.name: path for path in children if pattern.fullmatch(path.name) and is_folder(path)
    }
