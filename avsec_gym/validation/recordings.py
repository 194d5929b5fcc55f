"""The frames of a recording that a system of sensors can judge, and what the others lack."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.drives import recorded_drives
from avsec_gym.kitti.recording import Recording
from avsec_gym.sensor_system import KITTI_SYSTEM, LIDAR, Sensor, SensorSystem

_SAME_PLACE = 0.1
"""Metres; a camera this close to the reference sees no depth in it."""
_NAMED = 5
"""So many frames are named where one that was asked for is not there."""


@dataclass(frozen=True)
class RecordedFrame:
    """One frame of a recording, before it is read.

    Args:
        id: An id such as ``000107``, or ``2011_09_26_drive_0052_sync/0000000005`` of several
            drives.
        frame: Function that reads what the sensors deliver; DataError where a file is broken.
        drive: The drive of the frame, whose frames are alike; None: the frame stands alone.
    """

    id: str
    frame: Callable[[], SensorFrame]
    drive: str | None = None

    def read(self, system: SensorSystem) -> SensorFrame:
        """The frame with the data of all sensors read, so that a broken file is found here.

        Args:
            system: The sensors that are needed.

        Raises:
            DataError: A sensor is missing, or its file is broken.
        """
        frame = self.frame()
        for camera in system.cameras:
            frame.image(camera)
        if system.has_lidar:
            _ = frame.points
        return frame


@dataclass(frozen=True)
class Recordings:
    """What is there to be judged.

    Args:
        root: The folder that was named.
        system: The sensors.
        frames: The frames that have the data of all these sensors.
        lacking: What each of the other frames lacks, by its id.
        remark: The sensors that were left out, and why; empty if none was.
    """

    root: Path
    system: SensorSystem
    frames: tuple[RecordedFrame, ...]
    lacking: dict[str, str]
    remark: str = ""

    def first(self, count: int | None) -> Recordings:
        """The first frames, and what others up to the last of them lack; None: all."""
        if count is None or count > len(self.frames):
            return self
        frames = self.frames[:count]
        # Ids are in order: they are names of drives, and numbers with all their digits.
        lacking = {id: what for id, what in self.lacking.items() if id < frames[-1].id}
        return replace(self, frames=frames, lacking=lacking)

    def named(self, ids: Sequence[str]) -> tuple[RecordedFrame, ...]:
        """The frames with these ids, in the recording's order.

        Raises:
            DataError: One of them lacks a sensor, or is not there.
        """
        known = {recorded.id: recorded for recorded in self.frames}
        for id in ids:
            if id not in known:
                problem = (
                    f"The frame {id} lacks {self.lacking[id]}."
                    if id in self.lacking
                    else f"There is no frame {id}."
                )
                some = ", ".join([*known][:_NAMED]) + (", ..." if len(known) > _NAMED else "")
                raise DataError(
                    problem, path=self.root, remedy=f"The frames that can be judged are {some}."
                )
        return tuple(recorded for recorded in self.frames if recorded.id in set(ids))


def raw_recordings(root: str | Path, sensors: Sequence[Sensor] | None = None) -> Recordings:
    """Recordings of a drive, a day or a folder of days in KITTI's raw layout; or of sequences.

    Args:
        root: The folder, see `recorded_drives`: the tracking and the odometry benchmarks are read,
            too.
        sensors: S_0 to S_n; None: those that leave the most to judge, frames times sensors, see
            `system_of`: one that few frames have is left out, one that a few lack is not.

    Raises:
        DataError: There are fewer than three sensors, or no frame has all of them.
    """
    every = recorded_drives(root)
    if not every:
        raise DataError("There is no drive.", path=root, remedy="Fetch one from KITTI.")
    # Sequences of which labels alone are there deliver nothing.
    drives = [drive for drive in every if drive.sensors] or every
    frames = [(drive, *frame) for drive in drives for frame in _frames(drive)]
    remark = ""
    if sensors is None:
        counts = Counter(had for _, _, had in frames)
        system, remark = _fullest_system(drives[0].calibration, counts, root)
    else:
        system = SensorSystem(tuple(sensors))
    whole, lacking = [], {}
    for drive, number, had in frames:
        id = drive.frame_id(number)
        id = f"{drive.name}/{id}" if len(drives) > 1 else id
        missing = [_folder(drive, sensor) for sensor in system.sensors if sensor not in had]
        if missing:
            lacking[id] = ", ".join(missing)
        else:
            whole.append(RecordedFrame(id, partial(drive.frame, number, previous=0), drive.name))
    return _checked(Recordings(Path(root), system, tuple(whole), lacking, remark))


def object_recordings(
    root: str | Path, sensors: Sequence[Sensor] | None = None, split: str | None = None
) -> Recordings:
    """Recordings of a folder in KITTI's object layout: cameras 2 and 3 and the LiDAR.

    Raises:
        DataError: No frame has both images, the scan and the calibration.
    """
    data = KittiObject(root)
    system = SensorSystem((LIDAR, 3, 2) if sensors is None else tuple(sensors))
    folders = [
        "calib",
        *("velodyne" if sensor == LIDAR else f"image_{sensor}" for sensor in system.sensors),
    ]
    has = {folder: _ids(data, folder) for folder in folders}
    # KITTI's own labels and calibrations come without images: such frames are none.
    sensed = set().union(*(has[folder] for folder in folders[1:]))
    every = sorted(sensed) if split is None else data.ids(split)
    missing = {id: [folder for folder in folders if id not in has[folder]] for id in every}
    frames = tuple(
        RecordedFrame(id, partial(data.frame, id)) for id, folders in missing.items() if not folders
    )
    lacking = {id: ", ".join(folders) for id, folders in missing.items() if folders}
    return _checked(Recordings(Path(root), system, frames, lacking))


def drive_of(id: str) -> str:
    """The drive that a frame of `Recordings` belongs to; empty where there is one drive only.

    Example:
        >>> drive_of("2026_01_01_drive_0001_sync/0000000000"), drive_of("0000000007")
        ('2026_01_01_drive_0001_sync', '')
    """
    return id.rpartition("/")[0]


def system_of(calibration: Calibration, there: Iterable[Sensor], root: str | Path) -> SensorSystem:
    """KITTI's system where all its sensors are there, else everything that sees depth.

    Args:
        calibration: The calibration of the rig.
        there: The sensors that deliver something.
        root: The folder, for messages.

    Raises:
        DataError: They are fewer than three.
    """
    known = set(there)
    if known.issuperset(KITTI_SYSTEM.sensors) and calibration.cameras == (0, 1, 2, 3):
        return KITTI_SYSTEM
    cameras = [
        sensor for sensor in known if isinstance(sensor, int) and sensor in calibration.cameras
    ]
    cameras.sort(key=lambda camera: -float(calibration.camera_centre(camera)[0]))
    if cameras:
        reference = cameras[-1]
        cameras = [
            camera
            for camera in cameras
            if camera == reference or calibration.baseline(reference, camera) > _SAME_PLACE
        ]
    chosen: list[Sensor] = [*([LIDAR] if LIDAR in known else []), *cameras]
    if len(chosen) < 3:
        raise DataError(
            f"Three sensors or more can judge each other; here are {_named(chosen)}.",
            path=root,
            remedy="Fetch more of KITTI's folders: image_02 and image_03 with velodyne_points, "
            "or image_01 too.",
        )
    return SensorSystem(tuple(chosen))


def _fullest_system(
    calibration: Calibration, counts: Mapping[frozenset[Sensor], int], root: str | Path
) -> tuple[SensorSystem, str]:
    """The sensors that leave the most to judge, and a remark on the others.

    Not the most frames: a scan that is missing here and there is no reason to leave out the LiDAR.

    Args:
        calibration: The calibration of the rig.
        counts: How many frames have just these sensors.
        root: The folder, for messages.
    """

    def whole(system: SensorSystem) -> int:
        return sum(count for had, count in counts.items() if had.issuperset(system.sensors))

    everything = system_of(calibration, frozenset().union(*counts), root)
    # The best sensors are those that some frames have in common.
    common: set[frozenset[Sensor]] = set()
    for had in counts:
        common |= {had & other for other in common} | {had}
    systems = [everything]
    for there in sorted(common, key=lambda there: sorted(map(str, there))):
        with suppress(DataError):  # Fewer than three.
            systems.append(system_of(calibration, there, root))
    best = max(systems, key=lambda system: (len(system) * whole(system), len(system)))
    left_out = [sensor for sensor in everything.sensors if sensor not in best.sensors]
    if not left_out:
        return best, ""
    return best, (
        f"{_named(left_out)}: {whole(everything)} frames could be judged with it, {whole(best)} "
        f"can without; --sensors {' '.join(map(str, everything.sensors))} asks for it"
    )


def _ids(data: KittiObject, folder: str) -> set[str]:
    try:
        return set(data.ids(having=(folder,)))
    except DataError:
        return set()


def _checked(found: Recordings) -> Recordings:
    if not found.frames:
        first = next(iter(found.lacking.items()), None)
        raise DataError(
            f"No frame has all of {_named(found.system.sensors)}"
            + (f"; {first[0]} lacks {first[1]}." if first else "."),
            path=found.root,
            remedy="Fetch what is missing, which `avsec data check` lists; or judge other sensors: "
            "`avsec validate --sensors` (a fitted file states its own).",
        )
    try:
        found.system.check(found.frames[0].frame().calibration)
    except ConfigurationError as error:
        raise ConfigurationError(f"{found.root}: {error}") from error
    return found


def _frames(drive: Recording) -> Iterator[tuple[int, frozenset[Sensor]]]:
    """The numbers of a drive's frames, and which sensors have them."""
    there = {
        sensor: set(numbers)
        for name, numbers in drive.sensors.items()
        if (sensor := _sensor(drive, name)) is not None
    }
    for number in drive.frames():
        yield number, frozenset(sensor for sensor, numbers in there.items() if number in numbers)


def _sensor(drive: Recording, folder: str) -> Sensor | None:
    if folder == drive.scanner:
        return LIDAR
    return int(folder.rpartition("_")[2]) if folder.startswith("image_") else None


def _folder(drive: Recording, sensor: Sensor) -> str:
    return drive.scanner if sensor == LIDAR else drive.image_folder(int(sensor))


def _named(sensors: Iterable[Sensor]) -> str:
    names = [LIDAR if sensor == LIDAR else f"camera {sensor}" for sensor in sensors]
    return ", ".join(names) or "none"
