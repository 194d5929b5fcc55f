from __future__ import annotations

import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import box_corners, project
from avsec_gym.kitti.raw import Drive, KittiRaw, raw_file

DRIVE = "2026_01_01_drive_0007_sync"


def test_a_root_a_date_and_a_drive_may_be_named(
    raw_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    date = raw_root / "2026_01_01"
    monkeypatch.chdir(date / DRIVE)
    for root in (raw_root, date, date / DRIVE, Path("."), Path("..")):
        data = KittiRaw(root)
        assert data.dates() == ["2026_01_01"]
        assert data.drives() == [DRIVE]
        for name in (DRIVE, "2026_01_01_drive_0007", "0007"):
            assert data.drive(name).name == DRIVE
        assert data.drive("0007").calibration.cameras == (0, 1, 2, 3, 4)


def test_a_frame_has_everything(raw_root: Path, rig: Calibration) -> None:
    drive = KittiRaw(raw_root).drive("0007")
    assert drive.frames() == [0, 1, 2, 3]
    frame = drive.frame(2)
    assert frame.id == "0000000002"
    assert sorted(frame.images) == [0, 1, 2, 3, 4]
    assert frame.image(4).shape == (8, 12, 3)
    assert frame.points.shape == (50, 4)
    assert [earlier.id for earlier in frame.previous] == ["0000000001", "0000000000"]
    assert frame.previous[0].has_points
    assert drive.frame(3, previous=1).previous[0].id == "0000000002"
    assert frame.stereo().baseline == pytest.approx(rig.baseline())
    assert len(drive.oxts) == len(drive.poses) == len(drive.timestamps()) == 4
    np.testing.assert_array_equal(drive.timestamps("image_02"), drive.timestamps())
    again = pickle.loads(pickle.dumps(drive))
    np.testing.assert_array_equal(again.frame(2).image(3), frame.image(3))


def test_labels_are_tracklets_in_the_camera_frame(raw_root: Path) -> None:
    drive = KittiRaw(raw_root).drive("0007")
    assert [len(drive.labels(number)) for number in drive.frames()] == [0, 1, 1, 0]
    boxes = drive.labels(2)
    np.testing.assert_allclose(boxes.location, [[-2.0, 1.7, 19.0]], atol=1.0)
    assert boxes.truncation is not None
    assert boxes.truncation[0] == -1


def test_a_part_of_a_drive_loads(raw_root: Path) -> None:
    folder = raw_root / "2026_01_01" / DRIVE
    for name in ("oxts", "image_00", "image_01", "image_03", "image_04"):
        shutil.rmtree(folder / name)
    (folder / "tracklet_labels.xml").unlink()
    (folder / "image_02" / "data" / "0000000001.png").unlink()
    (folder / "velodyne_points" / "data" / "0000000002.bin").unlink()
    drive = Drive(folder)
    assert drive.sensors == {"image_02": (0, 2, 3), "velodyne_points": (0, 1, 3)}
    assert drive.frames() == [0, 1, 2, 3]
    assert drive.frames(["image_02", "velodyne_points"]) == [0, 3]
    assert not drive.frame(2).has_points
    assert not drive.frame(1).images
    with pytest.raises(DataError, match=r"has no oxts/data.*synced\+rectified"):
        _ = drive.poses
    with pytest.raises(DataError, match=r"no oxts/timestamps\.txt.*image_02, velodyne_points"):
        drive.timestamps()
    with pytest.raises(DataError, match=r"no tracklet_labels\.xml.*fetch"):
        drive.labels(0)
    with pytest.raises(DataError, match="no image of camera 3"):
        drive.frame(0).stereo()
    with pytest.raises(DataError, match="no frames of image_03"):
        drive.frames(["image_03"])
    with pytest.raises(DataError, match=r"no frame 7.*4 from 0 to 3"):
        drive.frame(7)


def test_without_calibration_the_rest_loads(raw_root: Path) -> None:
    for path in (raw_root / "2026_01_01").glob("calib_*.txt"):
        path.unlink()
    drive = KittiRaw(raw_root).drive("0007")
    assert len(drive.poses) == 4
    with pytest.raises(DataError, match=r"no calib_cam_to_cam\.txt.*folder of the date"):
        drive.frame(0)


def test_a_date_without_drives_has_its_calibration(raw_root: Path) -> None:
    shutil.rmtree(raw_root / "2026_01_01" / DRIVE)
    data = KittiRaw(raw_root)
    assert data.drives() == []
    assert data.calibration("2026_01_01").cameras == (0, 1, 2, 3, 4)
    with pytest.raises(DataError, match="no date 2011_09_26"):
        data.calibration("2011_09_26")
    with pytest.raises(DataError, match="No drives are named 0007"):
        data.drive("0007")


def test_names_must_be_clear(raw_root: Path) -> None:
    (raw_root / "2026_01_02" / "2026_01_02_drive_0007_sync").mkdir(parents=True)
    (raw_root / "2026_01_02" / "2026_01_02_drive_0008_extract").mkdir()
    data = KittiRaw(raw_root)
    assert len(data.drives()) == 2
    with pytest.raises(DataError, match="2 drives are named 0007"):
        data.drive("0007")
    empty = data.drive("2026_01_02_drive_0007")
    assert empty.frames() == []
    with pytest.raises(DataError, match="has none"):
        empty.frame(0)


def test_other_folders_are_refused(tmp_path: Path, object_root: Path) -> None:
    for root in (tmp_path, object_root):
        with pytest.raises(DataError, match="Nothing of the KITTI raw"):
            KittiRaw(root)
    for ask in (KittiRaw, Drive):
        with pytest.raises(DataError, match="no such"):
            ask(tmp_path / "2026_01_01" / DRIVE)
    for sensor, number in (("image_2", 0), ("../oxts", 0), ("oxts", -1)):
        with pytest.raises(ConfigurationError):
            raw_file(tmp_path, sensor, number)


def test_broken_files_are_named_when_they_are_read(raw_root: Path) -> None:
    folder = raw_root / "2026_01_01" / DRIVE
    for name, content in (
        ("image_02/data/0000000001.png", b"\x89PNG"),
        ("velodyne_points/data/0000000001.bin", bytes(17)),
        ("oxts/data/0000000001.txt", b"1 2 3\n"),
        ("oxts/timestamps.txt", b"yesterday\n"),
        ("tracklet_labels.xml", b"<boost_serialization>"),
    ):
        (folder / name).write_bytes(content)
    drive = Drive(folder)
    frame = drive.frame(1)
    for name, read in (
        ("0000000001.png", frame.image),
        ("0000000001.bin", lambda: frame.points),
        ("0000000001.txt:1", lambda: drive.oxts),
        ("timestamps.txt:1", drive.timestamps),
        ("tracklet_labels.xml:1", lambda: drive.tracklets),
    ):
        with pytest.raises(DataError, match=name.replace(".", r"\.")) as caught:
            read()
        assert caught.value.remedy


def test_the_real_partial_drive(shared: Path) -> None:
    data = KittiRaw(shared / "kitti/raw")
    assert [name[-9:] for name in data.drives()] == ["0001_sync", "0052_sync"]
    drive = data.drive("0052")
    both = drive.frames(["image_02", "velodyne_points"])
    assert both == [0, 5, 10, 15, 20]
    assert len(drive.frames()) == 11
    frame = drive.frame(10, previous=5)
    assert [earlier.id for earlier in frame.previous] == ["0000000005"]
    assert frame.image().shape == (375, 1242, 3)
    assert len(frame.points) > 80_000
    with pytest.raises(DataError, match="oxts"):
        _ = drive.oxts


def test_real_raw_and_object_calibration_agree(shared: Path) -> None:
    """Sequence 0000 of the tracking benchmark is of the same day."""
    from avsec_gym.kitti.calibration import read_calibration

    raw = KittiRaw(shared / "kitti/raw").calibration("2011_09_26")
    tracking = read_calibration(shared / "kitti/tracking/training/calib/0000.txt")
    for name in ("projections", "r0_rect", "tr_velo_to_cam", "tr_imu_to_velo"):
        np.testing.assert_array_equal(getattr(raw, name), getattr(tracking, name))


def test_real_tracklets_lie_before_the_camera(shared: Path) -> None:
    drive = KittiRaw(shared / "kitti/raw").drive("0001")
    calibration = drive.calibration
    for number in (0, 50, 100):
        boxes = drive.labels(number)
        assert len(boxes)
        assert boxes.truncation is not None
        inside = boxes[boxes.truncation == 0]
        corners = box_corners(inside.location, inside.dimensions, inside.rotation_y)
        pixels, depth = project(calibration.projection(), corners)
        assert (depth > 0).all()
        centres = pixels.mean(axis=1)
        assert ((centres > 0) & (centres < (1242, 375))).all()
        assert (np.abs(boxes.location[:, 1] - 1.7) < 1.5).all()
