"""Three scans of a KITTI raw drive, half a second apart, as if three vehicles took them at once.

The thesis' data (section 4.5): where all stands still, scans of one vehicle at intervals are scans
of several vehicles at one instant. What moves between them is in several places at once: each scan
has its own time, so that rays count only where a thing is known to have stood (`count_rays`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats
from avsec_gym.kitti.raw import OXTS, VELODYNE, Drive
from avsec_gym.kitti.sensor_files import read_points
from avsec_gym.validation.connected.raw_drive.registration import Registration, register
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

PosesBy = Literal["oxts", "registration"]
"""Measured by the inertial unit, or found by registering the scans onto the middle one."""


@dataclass(frozen=True, eq=False)
class DriveInstant(RecordedInstant):
    """Scans of a drive that stand for those of vehicles at one instant.

    Args:
        frames: The numbers of their frames.
        poses_by: Where their poses come from; the world is the velodyne frame of the middle one.
        registrations: How well each scan was registered onto the middle one, None for that itself;
            empty where poses are measured.
    """

    frames: tuple[int, ...] = ()
    poses_by: PosesBy = "oxts"
    registrations: tuple[Registration | None, ...] = ()


def drive_instants(
    drive: Drive,
    *,
    vehicles: int = 3,
    apart: int = 5,
    poses_by: PosesBy | None = None,
    left_out: dict[str, str] | None = None,
) -> Iterator[DriveInstant]:
    """The instants of a drive, one after the other; no scan is in two of them.

    Args:
        drive: The drive.
        vehicles: Scans of an instant.
        apart: Frames between them, 0.1 s each.
        poses_by: Where poses come from; None: oxts where all its frames have it, else
            registration.
        left_out: The dictionary that gets the reason for each instant of which a scan is broken, or
            two cannot be registered, by its name; None: that is an error.

    Raises:
        ConfigurationError: Fewer than two vehicles, or no frames between them.
        DataError: There are no such scans, one is broken, or two cannot be registered.
    """
    if vehicles < 2 or apart < 1:
        raise ConfigurationError(
            f"an instant has 2 scans or more that are 1 frame or more apart, got {vehicles} and"
            f" {apart}"
        )
    groups = spaced_groups(drive.sensors.get(VELODYNE, ()), vehicles, apart)
    if not groups:
        raise DataError(
            f"The drive has no {vehicles} scans that are {apart} frames apart.",
            path=drive.folder,
            remedy="Name a drive with more scans, or other intervals.",
        )
    for frames in groups:
        try:
            instant = _instant(drive, frames, poses_by)
        except DataError as error:
            if left_out is None:
                raise
            left_out[_name(drive, frames)] = str(error)
        else:
            yield instant


def spaced_groups(numbers: Sequence[int], size: int, apart: int) -> list[tuple[int, ...]]:
    """Groups of frames that follow each other at a distance, from the first on, none in two.

    Args:
        numbers: The frames that are there, sorted.
        size: Frames of a group.
        apart: Distance from one to the next.

    Example:
        >>> spaced_groups((0, 5, 10, 15, 20), 2, 5)
        [(0, 5), (10, 15)]
    """
    left, groups = set(numbers), []
    for first in numbers:
        group = tuple(range(first, first + size * apart, apart))
        if left.issuperset(group):
            groups.append(group)
            left.difference_update(group)
    return groups


def _name(drive: Drive, frames: tuple[int, ...]) -> str:
    return f"{drive.name}/{frames[len(frames) // 2]:010d}"


def _instant(drive: Drive, frames: tuple[int, ...], poses_by: PosesBy | None) -> DriveInstant:
    points = [read_points(drive.path(VELODYNE, number)) for number in frames]
    if poses_by is None:
        measured = drive.sensors.get(OXTS, ())
        known = set(frames) <= set(measured) and drive.calibration.tr_imu_to_velo is not None
        poses_by = "oxts" if known else "registration"
    registrations: tuple[Registration | None, ...] = ()
    middle = len(frames) // 2
    if poses_by == "oxts":
        poses = _measured_poses(drive, frames, middle)
    else:
        try:
            registrations = tuple(
                None if index == middle else register(scan, points[middle], _starts(index - middle))
                for index, scan in enumerate(points)
            )
        except DataError as error:
            raise DataError(
                f"Frames {', '.join(map(str, frames))}: {error.problem}",
                path=drive.folder,
                remedy=error.remedy,
            ) from error
        poses = [np.eye(4) if each is None else each.transform for each in registrations]
    return DriveInstant(
        _name(drive, frames),
        tuple(
            VehicleScan(scan, pose, _PERIOD * (number - frames[middle]), sweep)
            for scan, pose, sweep, number in zip(
                points, poses, _sweeps(poses, frames), frames, strict=True
            )
        ),
        frames=frames,
        poses_by=poses_by,
        registrations=registrations,
    )


def _sweeps(poses: Sequence[Floats], frames: Sequence[int]) -> list[RollingSweep]:
    """How each scan came about: raw scans are not compensated for the vehicle's own motion."""
    sweeps = []
    for index in range(len(poses)):
        first = min(index, len(poses) - 2)
        moved = np.linalg.inv(poses[first]) @ poses[first + 1]
        seconds = _PERIOD * (frames[first + 1] - frames[first])
        speed = float(np.hypot(*moved[:2, 3])) * np.sign(moved[0, 3]) / seconds
        turn_rate = float(np.arctan2(moved[1, 0], moved[0, 0])) / seconds
        sweeps.append(RollingSweep(speed, turn_rate, _PERIOD))
    return sweeps


_PERIOD = 0.1


def _starts(steps: int) -> list[float]:
    """Where registration begins to search: ahead for later scans, behind for earlier ones."""
    ahead = np.sign(steps) * np.arange(-2.0, 12.0 * abs(steps) + 1.0)
    return [float(start) for start in ahead]


def _measured_poses(drive: Drive, frames: Sequence[int], middle: int) -> list[Floats]:
    """From each velodyne frame to that of the middle scan, by the inertial unit."""
    places = {number: index for index, number in enumerate(drive.sensors.get(OXTS, ()))}
    if not set(frames) <= set(places):
        raise DataError(
            "Not all frames have measurements of oxts.",
            path=drive.folder,
            remedy="Let the poses be found by registration.",
        )
    to_world = drive.poses[[places[number] for number in frames]] @ _velodyne_to_imu(
        drive.calibration, drive
    )
    return list(np.linalg.inv(to_world[middle]) @ to_world)


def _velodyne_to_imu(calibration: Calibration, drive: Drive) -> Floats:
    if calibration.tr_imu_to_velo is None:
        raise DataError(
            "There is no calib_imu_to_velo.txt beside the drive.",
            path=drive.folder,
            remedy="Fetch KITTI's calibration of the day, or let the poses be found by"
            " registration.",
        )
    return np.linalg.inv(np.vstack([calibration.tr_imu_to_velo, [0.0, 0.0, 0.0, 1.0]]))
