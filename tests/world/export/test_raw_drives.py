"""Raw drives: KITTI's own tools read them, and their parts agree with one another."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pykitti
import pytest

from avsec_gym.kitti import Drive, KittiRaw, check_data, read_disparity, read_labels
from avsec_gym.rig import SensorRig
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.export import Sensors, make_data_set, suite_recipe


@pytest.fixture
def drive(raw: Path) -> Drive:
    return KittiRaw(raw).drive("0001")


def test_pykitti_reads_it(raw: Path, rig: SensorRig) -> None:
    theirs = pykitti.raw(str(raw), "2026_01_01", "0001")
    assert len(theirs) == len(theirs.timestamps) == 3
    assert theirs.calib.b_rgb == pytest.approx(rig.calibration.baseline())
    left, right = theirs.get_rgb(1)
    assert left.size == right.size == rig.size
    assert theirs.get_velo(2).shape[1] == 4
    scenes = drive_scenes(1, 0, 3, rig=rig)
    imu = scenes.world.ego_poses[:, 0] @ rig.imu_pose
    poses = np.stack([each.T_w_imu for each in theirs.oxts])
    np.testing.assert_allclose(poses[:, :3, :3], imu[:, :3, :3], atol=1e-6)
    moved = imu[:, :3, 3] - imu[0, :3, 3]
    np.testing.assert_allclose(poses[:, :3, 3], moved, atol=1e-3)


def test_the_readers_and_the_check_take_it(raw: Path, drive: Drive, rig: SensorRig) -> None:
    assert KittiRaw(raw).drives() == [f"2026_01_01_drive_000{i}_sync" for i in (1, 2)]
    frame = drive.frame(2)
    assert sorted(frame.images) == [0, 2, 3]
    np.testing.assert_allclose(frame.calibration.projections, rig.calibration.projections)
    assert len(frame.previous) == 2
    assert (np.diff(drive.timestamps("image_02")) == np.timedelta64(100, "ms")).all()
    assert check_data(raw, deep=True).ok
    assert len(KittiRaw(raw).drive("0002").oxts) == 1


def test_tracklets_are_the_labels_over_time(raw: Path) -> None:
    count = 0
    for name in ("0001", "0002"):
        drive = KittiRaw(raw).drive(name)
        for number in drive.frames():
            path = drive.folder / f"label_02/data/{number:010d}.txt"
            labels, tracked = read_labels(path), drive.labels(number)
            for place, size, turn, category in zip(
                labels.location, labels.dimensions, labels.rotation_y, labels.category, strict=True
            ):
                apart = np.linalg.norm(tracked.location - place, axis=1)
                nearest = int(apart.argmin())
                assert apart[nearest] < 0.01
                np.testing.assert_allclose(tracked.dimensions[nearest], size, atol=1e-4)
                # The velodyne is mounted a little askew, which a yaw alone cannot hold.
                assert abs(np.sin(tracked.rotation_y[nearest] - turn)) < 0.01
                assert tracked.category[nearest] == category
                count += 1
    assert count > 0


def test_truth_lies_beside_the_sensors(drive: Drive) -> None:
    for kind, suffix in {
        "disparity": "png",
        "surface": "png",
        "instance": "png",
        "moving": "txt",
        "scene": "json",
    }.items():
        names = sorted(path.name for path in (drive.folder / f"{kind}_02/data").iterdir())
        assert names == [f"{number:010d}.{suffix}" for number in range(3)]
    assert np.isfinite(read_disparity(drive.folder / "disparity_02/data/0000000000.png")).any()


def test_a_longer_set_begins_with_a_shorter_one(raw: Path, tmp_path: Path, rig: SensorRig) -> None:
    recipe = suite_recipe("raw", 1, seed=1, sensors=Sensors((0, 2, 3), rig=rig), drive_frames=3)
    make_data_set(recipe, tmp_path, workers=1)
    drive = "2026_01_01/2026_01_01_drive_0001_sync"
    for name in ("image_02/data/0000000000.png", "oxts/data/0000000000.txt"):
        assert (tmp_path / drive / name).read_bytes() == (raw / drive / name).read_bytes()
