"""pykitti, written by others, reads what our writers wrote, and agrees with our readers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pykitti
import pytest
from pykitti.utils import load_oxts_packets_and_poses, load_velo_scan, read_calib_file

from avsec_gym.frame import Calibration
from avsec_gym.kitti.oxts import FIELDS, write_oxts
from avsec_gym.kitti.oxts_poses import oxts_from_poses
from avsec_gym.kitti.raw import Drive, KittiRaw

from .conftest import curve


@pytest.fixture
def drive(raw_root: Path) -> Drive:
    return KittiRaw(raw_root).drive("0007")


@pytest.fixture
def oracle(raw_root: Path) -> pykitti.raw:
    return pykitti.raw(str(raw_root), "2026_01_01", "0007")


def test_calibration(drive: Drive, oracle: pykitti.raw, rig: Calibration) -> None:
    calibration, theirs = drive.calibration, oracle.calib
    for name in ("projections", "r0_rect", "tr_velo_to_cam", "tr_imu_to_velo"):
        np.testing.assert_array_equal(getattr(calibration, name), getattr(rig, name))
    projections = [getattr(theirs, f"P_rect_{i}0") for i in range(4)]
    np.testing.assert_array_equal(calibration.projections[:4], projections)
    np.testing.assert_allclose(calibration.velodyne_to_camera, theirs.T_cam0_velo, atol=1e-12)
    np.testing.assert_array_equal(calibration.tr_imu_to_velo, theirs.T_velo_imu[:3])
    assert calibration.baseline(0, 1) == pytest.approx(theirs.b_gray)
    assert calibration.baseline(2, 3) == pytest.approx(theirs.b_rgb)


def test_images_scans_and_times(drive: Drive, oracle: pykitti.raw) -> None:
    assert len(oracle) == 4
    for number in range(4):
        frame = drive.frame(number)
        for camera, get in ((2, oracle.get_cam2), (3, oracle.get_cam3)):
            np.testing.assert_array_equal(frame.image(camera), np.asarray(get(number)))
        for camera, get in ((0, oracle.get_cam0), (1, oracle.get_cam1)):
            np.testing.assert_array_equal(frame.image(camera)[..., 0], np.asarray(get(number)))
        np.testing.assert_array_equal(frame.points, oracle.get_velo(number))
    theirs = np.array(oracle.timestamps, "datetime64[us]")
    np.testing.assert_array_equal(drive.timestamps().astype("datetime64[us]"), theirs)


def test_poses(drive: Drive, oracle: pykitti.raw) -> None:
    np.testing.assert_allclose(
        drive.poses, [oxts.T_w_imu for oxts in oracle.oxts], rtol=0, atol=1e-7
    )
    packets = [[getattr(oxts.packet, name) for name in FIELDS] for oxts in oracle.oxts]
    np.testing.assert_array_equal(drive.oxts.rows, packets)


def test_written_poses_come_back_within_a_millimetre(tmp_path: Path) -> None:
    """Over 20 seconds; where latitude and longitude begin does not matter."""
    poses = curve(200)
    expected = poses.copy()
    expected[:, :3, 3] -= poses[0, :3, 3]
    for i, origin in enumerate([(49.0, 8.4, 115.0), (-33.0, 151.0, 5.0), (0.0, 0.0, 0.0)]):
        folder = tmp_path / str(i)
        write_oxts(folder, oxts_from_poses(poses, origin=origin))
        theirs = load_oxts_packets_and_poses(sorted(map(str, folder.iterdir())))
        found = np.array([oxts.T_w_imu for oxts in theirs])
        np.testing.assert_allclose(found[:, :3, 3], expected[:, :3, 3], rtol=0, atol=1e-6)
        np.testing.assert_allclose(found[:, :3, :3], expected[:, :3, :3], rtol=0, atol=1e-12)


def test_the_real_day_and_drives(shared: Path) -> None:
    """pykitti.raw cannot load a partial drive; its functions can."""
    raw = KittiRaw(shared / "kitti/raw")
    folder = shared / "kitti/raw/2011_09_26"
    cameras = read_calib_file(folder / "calib_cam_to_cam.txt")
    calibration = raw.calibration("2011_09_26")
    for i in range(4):
        np.testing.assert_array_equal(calibration.projections[i].ravel(), cameras[f"P_rect_0{i}"])
    np.testing.assert_array_equal(calibration.r0_rect.ravel(), cameras["R_rect_00"])
    partial = raw.drive("0052")
    scan = load_velo_scan(partial.path("velodyne_points", 5))
    np.testing.assert_array_equal(partial.frame(5).points, scan)
    with pytest.raises(FileNotFoundError):
        pykitti.raw(str(shared / "kitti/raw"), "2011_09_26", "0052")

    whole = pykitti.raw(str(shared / "kitti/raw"), "2011_09_26", "0001")
    drive = raw.drive("0001")
    np.testing.assert_array_equal(drive.poses, [oxts.T_w_imu for oxts in whole.oxts])
    np.testing.assert_array_equal(drive.oxts.rows[0], list(whole.oxts[0].packet))
    theirs = np.array(whole.timestamps, "datetime64[us]")
    np.testing.assert_array_equal(drive.timestamps().astype("datetime64[us]"), theirs)
