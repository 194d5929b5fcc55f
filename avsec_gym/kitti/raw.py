"""KITTI raw where the user has it, complete or in part: days, their drives, a drive's frames."""

from __future__ import annotations

import os
import re
from functools import cached_property
from pathlib import Path

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats
from avsec_gym.kitti.oxts import Oxts, read_oxts
from avsec_gym.kitti.oxts_poses import poses_from_oxts
from avsec_gym.kitti.raw_calibration import CALIBRATION_FILES, CAMERAS_FILE, read_raw_calibration
from avsec_gym.kitti.recording import Recording, frame_numbers, subfolders
from avsec_gym.kitti.timestamps import Timestamps, read_timestamps
from avsec_gym.kitti.tracklets import Tracklet, read_tracklets, tracklet_boxes
from avsec_gym.storage.regular_files import is_file, is_folder

VELODYNE, OXTS, TRACKLETS = "velodyne_points", "oxts", "tracklet_labels.xml"
"""What a drive may hold besides ``image_00``, ``image_01`` and so on."""

_DATE = re.compile(r"[0-9]{4}_[0-9]{2}_[0-9]{2}")
_DRIVE = re.compile(r"(?P<date>[0-9]{4}_[0-9]{2}_[0-9]{2})_drive_(?P<number>[0-9]{4,})_sync")
_IMAGES = re.compile(r"image_([0-9]{2})")
_DIGITS = 10
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
                "or a drive such as 2011_09_26_drive_0052_sync; `avsec data check` lists what a "
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


class Drive(Recording):
    """One recording; any part may be absent until it is asked for.

    Args:
        folder: The drive's folder, such as ``2011_09_26/2011_09_26_drive_0052_sync``; the
            calibration is beside it.

    Raises:
        DataError: There is no such folder.
    """

    def __init__(self, folder: str | Path) -> None:
        name = Path(os.path.abspath(folder)).name
        super().__init__(Path(folder), name, "drive", _SYNCED)
        if not is_folder(self.folder):
            raise DataError("There is no such drive.", path=folder, remedy="Check the path.")

    def __repr__(self) -> str:
        return f"Drive({str(self.folder)!r})"

    @cached_property
    def sensors(self) -> dict[str, tuple[int, ...]]:
        """The numbers of the frames of ``image_00`` and so on, of the LiDAR and of oxts."""
        numbers = {name: _numbers(self.folder, name) for name in _sensors(self.folder)}
        return {name: there for name, there in numbers.items() if there}

    @property
    def scanner(self) -> str:
        """The folder of the LiDAR's scans."""
        return VELODYNE

    def frame_id(self, number: int) -> str:
        """Ten digits."""
        return f"{number:0{_DIGITS}d}"

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

    def _has_timestamps(self, sensor: str) -> bool:
        return is_file(self.folder / sensor / "timestamps.txt")


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
    # An archive that was unzipped into a folder of its name holds the day.
    if match and is_folder(root) and not subfolders(root, _DATE):
        return {match["date"]: root.absolute().parent}, {name: root}
    dates = {name: root} if _DATE.fullmatch(name) and is_folder(root) else subfolders(root, _DATE)
    drives: dict[str, Path] = {}
    for date in dates.values():
        drives |= subfolders(date, _DRIVE)
    there = {
        name: date
        for name, date in dates.items()
        if subfolders(date, _DRIVE) or any(is_file(date / file) for file in CALIBRATION_FILES)
    }
    return there, drives


def raw_parts(root: Path) -> list[str]:
    """What a folder of days holds, relative to it: calibration, and the parts of each drive."""
    parts = []
    for date in subfolders(root, _DATE).values():
        parts += [date / CAMERAS_FILE] if is_file(date / CAMERAS_FILE) else []
        for drive in subfolders(date, _DRIVE).values():
            parts += [drive / name for name in _sensors(drive)]
            parts += [drive / TRACKLETS] if is_file(drive / TRACKLETS) else []
    return [str(part.relative_to(root)) for part in parts]


def _sensors(folder: Path) -> list[str]:
    return [*subfolders(folder, _IMAGES), *(name for name in _SUFFIXES if is_folder(folder / name))]


def _numbers(folder: Path, sensor: str) -> tuple[int, ...]:
    return frame_numbers(folder / sensor / "data", _DIGITS, _SUFFIXES.get(sensor, ".png"))


def _names(drive: str) -> tuple[str, ...]:
    """What a drive may be called: all of it, without the end, or its number."""
    match = _DRIVE.fullmatch(drive)
    return (drive, drive.removesuffix("_sync"), match["number"]) if match else (drive,)
