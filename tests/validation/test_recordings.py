"""Which sensors and frames of a recording are judged, and what is said of the rest."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.writing import write_object_frame, write_raw_frame
from avsec_gym.rig import kitti_rig
from avsec_gym.sensor_system import KITTI_SYSTEM, LIDAR
from avsec_gym.validation import recordings
from avsec_gym.validation.recordings import object_recordings, raw_recordings, system_of

DAY = "2026_01_01"
FOLDERS = {"lidar": "velodyne_points", **{str(c): f"image_0{c}" for c in range(4)}}
DriveOf = Callable[..., Path]


@pytest.fixture
def drive_of(tmp_path: Path, wall_of: Callable[[int], SensorFrame]) -> DriveOf:
    """A drive of walls seen by cameras 0 to 2 and the LiDAR, whose sensors lack some frames."""

    def make(number: int, lacking: Mapping[str, range], frames: int = 10) -> Path:
        wall = wall_of(0)
        drive = tmp_path / DAY / f"{DAY}_drive_{number:04d}_sync"
        write_raw_calibration(drive.parent, wall.calibration, image_size=(240, 120), overwrite=True)
        for frame in range(frames):
            write_raw_frame(drive, frame, wall)
        for sensor, missing in lacking.items():
            for frame in missing:
                suffix = ".bin" if sensor == LIDAR else ".png"
                (drive / FOLDERS[sensor] / "data" / f"{frame:010d}{suffix}").unlink()
        return drive

    return make


def test_a_sensor_that_few_frames_have_is_left_out_and_that_is_said(drive_of: DriveOf) -> None:
    drive = drive_of(1, {"1": range(2, 10)})
    found = raw_recordings(drive)
    assert found.system.sensors == (LIDAR, 2, 0)
    assert len(found.frames) == 10
    assert found.lacking == {}
    assert "camera 1: 2 frames" in found.remark
    assert "--sensors lidar 2 1 0" in found.remark
    # Who asks for it gets it.
    asked = raw_recordings(drive, (LIDAR, 2, 1, 0))
    assert [recorded.id for recorded in asked.frames] == [f"{n:010d}" for n in range(2)]
    assert asked.lacking == {f"{n:010d}": "image_01" for n in range(2, 10)}
    assert asked.remark == ""


def test_a_sensor_that_a_few_frames_lack_is_kept(drive_of: DriveOf) -> None:
    """KITTI's drive 0009 has 443 scans of 447: without the LiDAR, no sensor could be named."""
    found = raw_recordings(drive_of(1, {"lidar": range(2)}))
    assert found.system.sensors == (LIDAR, 2, 1, 0)
    assert found.lacking == {f"{n:010d}": "velodyne_points" for n in range(2)}
    assert len(found.frames) == 8
    assert found.remark == ""


def test_sensors_of_several_drives_are_those_that_most_of_them_share(drive_of: DriveOf) -> None:
    drive_of(1, {}, frames=1)
    root = drive_of(2, {"1": range(4), "lidar": range(4)}, frames=4).parent
    with pytest.raises(DataError, match="No frame has all"):
        raw_recordings(root / f"{DAY}_drive_0002_sync", (LIDAR, 1, 0))
    assert raw_recordings(root).system.sensors == (LIDAR, 2, 1, 0), (
        "two cameras cannot judge each other"
    )
    drive_of(3, {"1": range(9)}, frames=9)
    found = raw_recordings(root)
    assert found.system.sensors == (LIDAR, 2, 0)
    assert [recorded.drive for recorded in found.frames].count(f"{DAY}_drive_0003_sync") == 9
    assert found.frames[0].id == f"{DAY}_drive_0001_sync/0000000000"
    assert found.lacking == {f"{DAY}_drive_0002_sync/{n:010d}": "velodyne_points" for n in range(4)}


def test_the_first_frames_keep_what_others_before_them_lack(drive_of: DriveOf) -> None:
    found = raw_recordings(drive_of(1, {"2": range(3, 5)}))
    first = found.first(4)
    assert [recorded.id[-1] for recorded in first.frames] == ["0", "1", "2", "5"]
    assert list(first.lacking) == ["0000000003", "0000000004"]
    assert found.first(3).lacking == {}
    assert found.first(None) is found.first(99) is found


def test_frames_are_found_by_their_ids(drive_of: DriveOf) -> None:
    found = raw_recordings(drive_of(1, {"2": range(3, 5)}))
    named = found.named(["0000000007", "0000000001"])
    assert [recorded.id for recorded in named] == ["0000000001", "0000000007"]
    with pytest.raises(DataError, match=r"frame 0000000003 lacks image_02.*0000000000, 0000000001"):
        found.named(["0000000001", "0000000003"])
    with pytest.raises(DataError, match="There is no frame 0000000012"):
        found.named(["0000000012"])


def test_too_few_sensors_or_another_order_are_refused(drive_of: DriveOf) -> None:
    drive = drive_of(1, {}, frames=1)
    with pytest.raises(ConfigurationError, match="from right to left"):
        raw_recordings(drive, (LIDAR, 0, 1))
    for camera in (0, 1):
        shutil.rmtree(drive / f"image_0{camera}")
    with pytest.raises(DataError, match="here are lidar, camera 2"):
        raw_recordings(drive)


@pytest.mark.parametrize(
    ("there", "expected"),
    [
        ({LIDAR, 0, 1, 2, 3}, KITTI_SYSTEM.sensors),
        ({LIDAR, 0, 1, 2, 3, 9}, KITTI_SYSTEM.sensors),
        # Camera 0 stands 6 cm from camera 2, and sees no depth in its view.
        ({LIDAR, 0, 2, 3}, (LIDAR, 3, 2)),
        ({LIDAR, 0, 1, 3}, (LIDAR, 1, 3, 0)),
        ({0, 1, 2, 3}, (1, 3, 2)),
    ],
)
def test_the_system_is_what_sees_depth(there: set[int | str], expected: tuple[int | str]) -> None:
    assert system_of(kitti_rig().calibration, there, "a drive").sensors == expected


@pytest.mark.parametrize("there", [(), (LIDAR,), (LIDAR, 0, 2), (2, 3)], ids=str)
def test_two_sensors_are_no_system(there: tuple[int | str, ...]) -> None:
    with pytest.raises(DataError, match="Three sensors"):
        system_of(kitti_rig().calibration, there, "a drive")


def test_object_frames_need_both_images_scan_and_calibration(
    tmp_path: Path, wall_of: Callable[[int], SensorFrame]
) -> None:
    wall, calibration = wall_of(0), kitti_rig().calibration
    images = {2: wall.image(0), 3: wall.image(1)}
    for number in range(3):
        frame = SensorFrame(f"{number:06d}", calibration, images, wall.points)
        write_object_frame(tmp_path / "training", frame)
    (tmp_path / "training" / "velodyne" / "000001.bin").unlink()
    # A calibration alone is no frame.
    calib = tmp_path / "training" / "calib"
    shutil.copy(calib / "000000.txt", calib / "000007.txt")
    found = object_recordings(tmp_path)
    assert found.system.sensors == (LIDAR, 3, 2)
    assert [recorded.id for recorded in found.frames] == ["000000", "000002"]
    assert found.lacking == {"000001": "velodyne"}
    with pytest.raises(DataError, match="No frame has all of lidar, camera 1"):
        object_recordings(tmp_path, (LIDAR, 1, 2))


def test_drives_of_frames() -> None:
    assert [recordings.drive_of(id) for id in ("a/b/7", "a/7", "7")] == ["a/b", "a", ""]
