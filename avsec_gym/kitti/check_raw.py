"""The look through KITTI raw: days, drives, and what each drive has and lacks."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.kitti.check_object import look_at_image, look_at_scan
from avsec_gym.kitti.oxts import read_oxts
from avsec_gym.kitti.raw import OXTS, TRACKLETS, VELODYNE, Drive, find_raw
from avsec_gym.kitti.raw_calibration import CALIBRATION_FILES, IMU_FILE, read_raw_calibration
from avsec_gym.kitti.report import FileCheck, Files, Sizes, Survey
from avsec_gym.kitti.timestamps import read_timestamps
from avsec_gym.kitti.tracklets import read_tracklets
from avsec_gym.storage.regular_files import is_file

_USUAL = ("image_00", "image_01", "image_02", "image_03", VELODYNE, OXTS)
_TOGETHER = (
    ("image_02", "image_03"),
    ("image_03", "image_02"),
    ("image_02", VELODYNE),
    (VELODYNE, "image_02"),
    ("image_02", OXTS),
)
_WITHOUT = {VELODYNE: "scans", OXTS: "speeds or poses", "image_03": "stereo pairs"}


def check_raw(survey: Survey, *, deep: bool) -> None:
    """Look at every file of the days and drives in a root, a day or a drive."""
    dates, folders = find_raw(survey.root)
    drives = [Drive(folder) for _, folder in sorted(folders.items())]
    groups = [_calibration(survey, folder) for _, folder in sorted(dates.items())]
    for drive in drives:
        groups += _sensors(survey, drive, deep)
    survey.look_at(groups)
    for drive in drives:
        _compare(survey, drive)
    for folder in {survey.root, *dates.values()}:
        survey.notes += [
            f"{survey.name(path)} holds unrectified data, which is not read."
            for path in sorted(folder.glob("*_drive_*_extract"))
        ]
    if not drives:
        survey.notes.append(
            "There is no drive; drives are folders such as "
            "2011_09_26/2011_09_26_drive_0052_sync, so named."
        )


def _calibration(survey: Survey, date: Path) -> Files:
    there = [date / name for name in CALIBRATION_FILES if is_file(date / name)]
    missing = [name for name in CALIBRATION_FILES if date / name not in there]
    if missing:
        harm = "where the inertial unit is, is unknown"
        harm = harm if missing == [IMU_FILE] else "frames cannot be loaded"
        survey.notes.append(f"{survey.name(date)} has no {', '.join(missing)}: {harm}.")

    def look(path: Path, _: Counter[str], __: Sizes) -> None:
        if path == there[0] and (not missing or missing == [IMU_FILE]):
            read_raw_calibration(date)

    return Files(date, there, look)


def _sensors(survey: Survey, drive: Drive, deep: bool) -> list[Files]:
    """The files of each sensor, then those of the drive as a whole."""
    groups = []
    for sensor, numbers in drive.sensors.items():
        folder = drive.folder / sensor / "data"
        paths = [drive.path(sensor, number) for number in numbers]
        survey.note_others(folder, sorted(set(folder.iterdir()) - set(paths)))
        looks: dict[str, FileCheck] = {VELODYNE: look_at_scan(deep), OXTS: _look_at_oxts}
        groups.append(Files(folder, paths, looks.get(sensor) or look_at_image(deep)))
    others = sorted(drive.folder.glob("*/timestamps*.txt"))
    others += [path for path in [drive.folder / TRACKLETS] if is_file(path)]

    def look(path: Path, objects: Counter[str], _: Sizes) -> None:
        if path.name == TRACKLETS:
            objects.update(tracklet.category for tracklet in read_tracklets(path))
        else:
            _check_timestamps(path, drive.sensors.get(path.parent.name, ()))

    return [*groups, Files(drive.folder, others, look)] if others else groups


def _look_at_oxts(path: Path, _: Counter[str], __: Sizes) -> None:
    read_oxts(path)


def _check_timestamps(path: Path, numbers: tuple[int, ...]) -> None:
    times = read_timestamps(path)
    if numbers and numbers[-1] >= len(times):
        raise DataError(
            f"There are {len(times)} times, but the last frame is {numbers[-1]}, counted from 0.",
            path=path,
            remedy="The file may be cut off; fetch it again.",
        )


def _compare(survey: Survey, drive: Drive) -> None:
    name, sensors = survey.name(drive.folder), drive.sensors
    missing = [sensor for sensor in _USUAL if sensor not in sensors]
    if missing:
        harms = [f"no {_WITHOUT[sensor]}" for sensor in missing if sensor in _WITHOUT]
        without = f": {', '.join(harms)}" if harms else ""
        survey.notes.append(f"{name} has no {', '.join(missing)}{without}.")
    untimed = [s for s in sensors if not is_file(drive.folder / s / "timestamps.txt")]
    if untimed:
        survey.notes.append(f"{name} has no timestamps of {', '.join(untimed)}.")
    if not is_file(drive.folder / TRACKLETS):
        survey.notes.append(f"{name} has no {TRACKLETS}; KITTI labelled some drives only.")
    for sensor, numbers in sensors.items():
        span = numbers[-1] - numbers[0] + 1
        if len(numbers) < span:
            survey.notes.append(
                f"{name}/{sensor} has {len(numbers)} of the {span} frames from {numbers[0]} "
                f"to {numbers[-1]}."
            )
    ids = {sensor: [f"{number:010d}" for number in there] for sensor, there in sensors.items()}
    for has, lacks in _TOGETHER:
        if has in ids and lacks in ids:
            survey.compare(f"{name}/{has}", ids[has], f"{name}/{lacks}", ids[lacks])
    left, right = (drive.folder / image / "data" for image in ("image_02", "image_03"))
    survey.compare_sizes(left, right)
