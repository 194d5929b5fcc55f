"""KITTI raw where the user has it, complete or in part: days, their drives, a drive's frames."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, LazyImages, SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.kitti.oxts import Oxts, read_oxts
from avsec_gym.kitti.oxts_poses import poses_from_oxts
from avsec_gym.kitti.raw_calibration import CALIBRATION_FILES, read_raw_calibration
from avsec_gym.kitti.sensor_files import ImageFile, ScanFile
from avsec_gym.kitti.timestamps import Timestamps, read_timestamps
from avsec_gym.kitti.tracklets import Tracklet, read_tracklets, tracklet_boxes
from avsec_gym.storage.regular_files import is_file, is_folder

VELODYNE, OXTS, TRACKLETS = "velodyne_points", "oxts", "tracklet_labels.xml"
"""What a drive may hold besides ``image_00``, ``image_01`` and so on."""

_DATE = re.compile(r"[0-9]{4}_[0-9]{2}_[0-9]{2}")
_DRIVE = re.compile(r"(?P<date>[0-9]{4}_[0-9]{2}_[0-9]{2})_drive_(?P<number>[0-9]{4,})_sync")
_IMAGES = re.compile(r"image_([0-9]{2})")
_FRAME = re.compile(r"[0-9]{10}")
_SUFFIXES = {VELODYNE: ".bin", OXTS: ".txt"}
_SYNCED = 'Fetch the "synced+rectified data" of the drive from KITTI'


class KittiRaw:
    """The official layout: ``2011_09_26/`` with calibration files and drives.

    Args:
        root: The folder that holds the dates, the folder of a date, or that of a drive.

    Raises:
        DataError: Nothing of the layout is there.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root)
        self._dates, self._drives = find_raw(self.root)
        if not self._dates:
            raise DataError(
                "Nothing of the KITTI raw layout is here."
                if is_folder(self.root)
                else "There is no such folder.",
                path=self.root,
                remedy="Name the folder that holds dates such as 2011_09_26, the folder of a date, "
                "or a drive such as 2011_09_26_drive_0052_sync; `avsec data check` says what a "
                "folder holds.",
            )

    def dates(self) -> list[str]:
        """The days, such as ``2011_09_26``, sorted."""
        return sorted(self._dates)

    def drives(self) -> list[str]:
        """The drives, such as ``2011_09_26_drive_0052_sync``, sorted; none where none is there."""
        return sorted(self._drives)

    def calibration(self, date: str) -> Calibration:
        """Calibration of a day, also of one without drives; see `read_raw_calibration`."""
        if date not in self._dates:
            raise DataError(
                f"There is no date {date}.",
                path=self.root,
                remedy=f"There are {', '.join(self.dates())}.",
            )
        return read_raw_calibration(self._dates[date])

    def drive(self, name: str) -> Drive:
        """A drive.

        Args:
            name: Name of the drive, such as ``2011_09_26_drive_0052_sync``; ``0052`` where only one
                day has it.

        Raises:
            DataError: There is no such drive, or several.
        """
        found = [drive for drive in self.drives() if name in _names(drive)]
        if len(found) != 1:
            raise DataError(
                f"{len(found) or 'No'} drives are named {name}.",
                path=self.root,
                remedy=f"Name one of {', '.join(found or self.drives()) or 'none'}.",
            )
        return Drive(self._drives[found[0]])


class Drive:
    """One recording; any part may be absent until it is asked for.

    Args:
        folder: The drive's folder, such as ``2011_09_26/2011_09_26_drive_0052_sync``; the
            calibration is beside it.

    Raises:
        DataError: There is no such folder.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        if not is_folder(self.folder):
            raise DataError("There is no such drive.", path=folder, remedy="Check the path.")

    def __repr__(self) -> str:
        return f"Drive({str(self.folder)!r})"

    @property
    def name(self) -> str:
        """Such as ``2011_09_26_drive_0052_sync``."""
        return Path(os.path.abspath(self.folder)).name

    @cached_property
    def sensors(self) -> dict[str, tuple[int, ...]]:
        """The numbers of the frames that each sensor has, sorted, by the sensor's folder.

        Sensors without any frame are left out.
        """
        numbers = {name: _numbers(self.folder, name) for name in _sensors(self.folder)}
        return {name: there for name, there in numbers.items() if there}

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
                raise self._absent(f"{name}/data", f"{_SYNCED}, or ask for what is there")
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
                remedy=f"The drive has {span}.",
            )
        before = [self._frame_alone(number - step) for step in range(1, previous + 1)]
        earlier = tuple(frame for frame in before if frame.images or frame.has_points)
        now = self._frame_alone(number)
        return SensorFrame(now.id, now.calibration, now.images, now.scan, earlier, self.folder)

    @cached_property
    def calibration(self) -> Calibration:
        """Of the drive's day; see `read_raw_calibration`."""
        return read_raw_calibration(self.folder.absolute().parent)

    @cached_property
    def oxts(self) -> Oxts:
        """What the inertial unit measured at the frames ``self.frames(["oxts"])``.

        Raises:
            DataError: It is not there, or a file is broken.
        """
        if OXTS not in self.sensors:
            raise self._absent("oxts/data", f"Speeds and poses are in it. {_SYNCED}")
        return read_oxts(self.path(OXTS, number) for number in self.sensors[OXTS])

    @cached_property
    def poses(self) -> Floats:
        """From the inertial unit to the world at the frames of `oxts`; see `poses_from_oxts`."""
        return poses_from_oxts(self.oxts)

    def timestamps(self, sensor: str = OXTS) -> Timestamps:
        """When a sensor's frames were recorded; element i is frame i.

        Raises:
            DataError: The drive has no such file, or it is broken.
        """
        path = self.folder / sensor / "timestamps.txt"
        if not is_file(path):
            there = [name for name in _sensors(self.folder) if self._has_timestamps(name)]
            also = f"Here are those of {', '.join(there)}. " if there else ""
            raise self._absent(f"{sensor}/timestamps.txt", f"{also}{_SYNCED}")
        return read_timestamps(path)

    @cached_property
    def tracklets(self) -> tuple[Tracklet, ...]:
        """The labelled objects; see `read_tracklets`.

        Raises:
            DataError: The drive has no labels, or the file is broken.
        """
        path = self.folder / TRACKLETS
        if not is_file(path):
            raise self._absent(
                TRACKLETS, "KITTI labelled some drives only; fetch the drive's tracklets"
            )
        return read_tracklets(path)

    def labels(self, number: int) -> Boxes3D:
        """The labelled objects of a frame in the camera frame; see `tracklet_boxes`."""
        return tracklet_boxes(self.tracklets, number, self.calibration)

    def path(self, sensor: str, number: int) -> Path:
        """The file of a frame, whether or not it is there."""
        return raw_file(self.folder, sensor, number)

    def _frame_alone(self, number: int) -> SensorFrame:
        images = {
            int(match[1]): ImageFile(self.path(name, number))
            for name, there in self.sensors.items()
            if (match := _IMAGES.fullmatch(name)) and number in there
        }
        has_scan = number in self.sensors.get(VELODYNE, ())
        return SensorFrame(
            f"{number:010d}",
            self.calibration,
            LazyImages(images),
            ScanFile(self.path(VELODYNE, number)) if has_scan else None,
            origin=self.folder,
        )

    def _has_timestamps(self, sensor: str) -> bool:
        return is_file(self.folder / sensor / "timestamps.txt")

    def _absent(self, what: str, remedy: str) -> DataError:
        return DataError(f"The drive has no {what}.", path=self.folder, remedy=f"{remedy}.")


def raw_file(folder: Path, sensor: str, number: int) -> Path:
    """Where the raw layout keeps a frame of a sensor in the folder of a drive.

    Raises:
        ConfigurationError: There is no such sensor in the layout, or the number is negative.
    """
    if number < 0 or not (sensor in _SUFFIXES or _IMAGES.fullmatch(sensor)):
        raise ConfigurationError(f"the raw layout has no frame {number} of a sensor {sensor!r}")
    return folder / sensor / "data" / f"{number:010d}{_SUFFIXES.get(sensor, '.png')}"


def find_raw(root: Path) -> tuple[dict[str, Path], dict[str, Path]]:
    """Folders of dates and of drives in a root, a date or a drive; empty where it is none."""
    name = Path(os.path.abspath(root)).name
    match = _DRIVE.fullmatch(name)
    if match and is_folder(root):
        return {match["date"]: root.absolute().parent}, {name: root}
    dates = {name: root} if _DATE.fullmatch(name) and is_folder(root) else _folders(root, _DATE)
    drives: dict[str, Path] = {}
    for date in dates.values():
        drives |= _folders(date, _DRIVE)
    there = {
        name: date
        for name, date in dates.items()
        if _folders(date, _DRIVE) or any(is_file(date / file) for file in CALIBRATION_FILES)
    }
    return there, drives


def _folders(folder: Path, pattern: re.Pattern[str]) -> dict[str, Path]:
    try:
        children = sorted(folder.iterdir())
    except (OSError, ValueError):
        return {}
    return {
        path.name: path for path in children if pattern.fullmatch(path.name) and is_folder(path)
    }


def _sensors(folder: Path) -> list[str]:
    return [*_folders(folder, _IMAGES), *(name for name in _SUFFIXES if is_folder(folder / name))]


def _numbers(folder: Path, sensor: str) -> tuple[int, ...]:
    data = folder / sensor / "data"
    numbers, expected = [], _SUFFIXES.get(sensor, ".png")
    for name in os.listdir(data) if is_folder(data) else ():
        stem, suffix = os.path.splitext(name)
        if suffix == expected and _FRAME.fullmatch(stem):
            numbers.append(int(stem))
    return tuple(sorted(numbers))


def _names(drive: str) -> tuple[str, ...]:
    """What a drive may be called: all of it, without the end, or its number."""
    match = _DRIVE.fullmatch(drive)
    return (drive, drive.removesuffix("_sync"), match["number"]) if match else (drive,)
