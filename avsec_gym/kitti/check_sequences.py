"""The look through KITTI's benchmarks of sequences: tracking and odometry."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from avsec_gym.kitti import odometry, tracking_sequences
from avsec_gym.kitti.archives import ARCHIVES
from avsec_gym.kitti.calibration import read_odometry_calibration
from avsec_gym.kitti.check_object import look_at_calibration, look_at_scan
from avsec_gym.kitti.layouts import tracking_folders
from avsec_gym.kitti.number_tables import read_numbers
from avsec_gym.kitti.odometry import KittiOdometry, OdometrySequence
from avsec_gym.kitti.oxts import read_oxts_table
from avsec_gym.kitti.report import FileCheck, Files, Sizes, Survey
from avsec_gym.kitti.sensor_files import read_image, read_image_size
from avsec_gym.kitti.tracking import read_tracking_labels
from avsec_gym.kitti.tracking_sequences import TrackingSequence, sequence_names
from avsec_gym.storage.regular_files import is_file, is_folder

_SEQUENCE_FILE = re.compile(r"[0-9]{4}\.txt")


def check_tracking(survey: Survey, *, deep: bool) -> None:
    """Look at every file of the tracking benchmark, or of its labels alone."""
    groups: list[Files] = []
    halves = tracking_folders(survey.root)
    for half in halves:
        if half.name == tracking_sequences.LABELS:
            groups.append(_texts(survey, half, _look_at_labels))
            continue
        texts: dict[str, FileCheck] = {
            tracking_sequences.LABELS: _look_at_labels,
            tracking_sequences.CALIBRATION: look_at_calibration,
            tracking_sequences.OXTS: _look_at_oxts,
        }
        groups += [
            _texts(survey, half / name, look)
            for name, look in texts.items()
            if is_folder(half / name)
        ]
        sequences = [TrackingSequence(half, name) for name in sequence_names(half)]
        groups += _sensors(half, sequences, deep)
        label = f"{half.name}/" if half != survey.root else ""
        expected = list(tracking_sequences.FOLDERS)
        if half.name == "testing":
            expected.remove(tracking_sequences.LABELS)
        missing = [name for name in expected if not is_folder(half / name)]
        _note_missing(survey, "tracking", label, missing)
        _compare(survey, label, sequences, (("image_02", "image_03"), ("image_02", "velodyne")))
    survey.look_at(groups)


def check_odometry(survey: Survey, *, deep: bool) -> None:
    """Look at every file of the odometry benchmark."""
    data = KittiOdometry(survey.root)
    sequences = [data.sequence(name) for name in data.sequences()]
    folder = data.folder / odometry.SEQUENCES
    groups = _sensors(folder, sequences, deep)
    for name, look in (
        (odometry.CALIBRATION, _look_at_odometry_calibration),
        (odometry.TIMES, _look_at_times),
    ):
        paths = [sequence.folder / name for sequence in sequences]
        groups.append(Files(folder / name, [path for path in paths if is_file(path)], look))
    poses = data.folder / odometry.POSES
    paths = [poses / f"{sequence.name}.txt" for sequence in sequences]
    groups.append(Files(poses, [path for path in paths if is_file(path)], _look_at_poses))
    survey.look_at(groups)
    every = {name for sequence in sequences for name in sequence.sensors}
    missing = [f"image_{i}" for i in range(4) if f"image_{i}" not in every]
    missing += [odometry.VELODYNE] if odometry.VELODYNE not in every else []
    missing += [] if is_folder(poses) else [odometry.POSES]
    _note_missing(survey, "odometry", "", missing)
    _compare(survey, "", sequences, (("image_2", "image_3"), ("image_2", "velodyne")))


def _texts(survey: Survey, folder: Path, look: FileCheck) -> Files:
    """A file for each sequence; what else lies there becomes a note."""
    every = sorted(folder.iterdir())
    sequences = [path for path in every if _SEQUENCE_FILE.fullmatch(path.name)]
    survey.note_others(folder, [path for path in every if path not in sequences])
    return Files(folder, sequences, look)


def _sensors(
    folder: Path, sequences: Sequence[TrackingSequence | OdometrySequence], deep: bool
) -> list[Files]:
    """The files of each sensor, of all sequences together."""
    groups = []
    for sensor in sorted({name for sequence in sequences for name in sequence.sensors}):
        paths = [
            sequence.path(sensor, number)
            for sequence in sequences
            for number in sequence.sensors.get(sensor, ())
        ]
        look = look_at_scan(deep) if sensor == sequences[0].scanner else _look_at_image(deep)
        groups.append(Files(folder / sensor, paths, look))
    return groups


def _look_at_image(deep: bool) -> FileCheck:
    """As of the object benchmark, but frames of all sequences are named alike."""

    def look(path: Path, _: Counter[str], sizes: Sizes) -> None:
        sizes[str(path)] = read_image_size(path)
        if deep:
            read_image(path)

    return look


def _look_at_labels(path: Path, objects: Counter[str], _: Sizes) -> None:
    for frame in read_tracking_labels(path, keep_dont_care=True).values():
        objects.update(frame.boxes.category.tolist())


def _look_at_oxts(path: Path, _: Counter[str], __: Sizes) -> None:
    read_oxts_table(path)


def _look_at_odometry_calibration(path: Path, _: Counter[str], __: Sizes) -> None:
    read_odometry_calibration(path)


def _look_at_times(path: Path, _: Counter[str], __: Sizes) -> None:
    read_numbers(path, 1)


def _look_at_poses(path: Path, _: Counter[str], __: Sizes) -> None:
    read_numbers(path, 12)


def _note_missing(survey: Survey, kind: str, label: str, missing: Sequence[str]) -> None:
    survey.notes += [
        f"There is no folder {label}{name}; {ARCHIVES[kind][name]} brings it." for name in missing
    ]


def _compare(
    survey: Survey,
    label: str,
    sequences: Sequence[TrackingSequence | OdometrySequence],
    together: Sequence[tuple[str, str]],
) -> None:
    """Report frames that have one sensor and lack the other, where there is any of both."""
    every = {name for sequence in sequences for name in sequence.sensors}
    for has, lacks in together:
        if has in every and lacks in every:
            ids = {sensor: _ids(sequences, sensor) for sensor in (has, lacks)}
            survey.compare(f"{label}{has}", ids[has], f"{label}{lacks}", ids[lacks])


def _ids(sequences: Sequence[TrackingSequence | OdometrySequence], sensor: str) -> list[str]:
    return [
        f"{sequence.name}/{sequence.frame_id(number)}"
        for sequence in sequences
        for number in sequence.sensors.get(sensor, ())
    ]
