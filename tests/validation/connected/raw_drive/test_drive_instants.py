"""Scans of a drive at intervals, with poses by oxts or by registration."""

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import transform_points
from avsec_gym.kitti.calibration import read_calibration
from avsec_gym.kitti.oxts import write_oxts
from avsec_gym.kitti.oxts_poses import oxts_from_poses
from avsec_gym.kitti.raw import KittiRaw
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.sensor_files import write_points
from avsec_gym.validation.connected.raw_drive.drive_instants import drive_instants, spaced_groups

_REAL = Path(__file__).parents[5] / "shared" / "kitti" / "raw"
_CALIBRATION = (
    "P0: 721 0 609 0 0 721 172 0 0 0 1 0\nP1: 721 0 609 -387 0 721 172 0 0 0 1 0\n"
    "P2: 721 0 609 44.8 0 721 172 0.2 0 0 1 0.0027\nP3: 721 0 609 -339 0 721 172 2 0 0 1 0.0027\n"
    "R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27\n"
    "Tr_imu_to_velo: 1 0 0 -0.81 0 1 0 0.32 0 0 1 -0.8\n"
)


def _drive(root: Path) -> Path:
    """Eleven frames on an arc; every scan holds one landmark of the world."""
    date = root / "2026_01_01"
    drive = date / "2026_01_01_drive_0001_sync"
    (drive / "velodyne_points" / "data").mkdir(parents=True)
    (drive / "oxts" / "data").mkdir(parents=True)
    (date / "c.txt").write_text(_CALIBRATION)
    calibration = read_calibration(date / "c.txt")
    write_raw_calibration(date, calibration)
    heading = np.linspace(0.2, 0.6, 11)
    unit = np.tile(np.eye(4), (11, 1, 1))
    unit[:, 0, 0], unit[:, 0, 1] = np.cos(heading), -np.sin(heading)
    unit[:, 1, 0], unit[:, 1, 1] = np.sin(heading), np.cos(heading)
    unit[:, 0, 3], unit[:, 1, 3] = 0.8 * np.arange(11), 0.1 * np.arange(11) ** 1.5
    write_oxts(drive / "oxts" / "data", oxts_from_poses(unit))
    assert calibration.tr_imu_to_velo is not None
    to_velodyne = np.vstack([calibration.tr_imu_to_velo, [0, 0, 0, 1]])
    for number, pose in enumerate(unit):
        landmark = to_velodyne @ np.linalg.inv(pose) @ [20.0, 5.0, 1.0, 1.0]
        path = drive / "velodyne_points" / "data" / f"{number:010d}.bin"
        write_points(path, np.array([[*landmark[:3], 0.5]], np.float32))
    return drive


def test_poses_by_oxts_bring_a_landmark_to_one_place(tmp_path: Path) -> None:
    drive = KittiRaw(_drive(tmp_path)).drive("0001")
    [instant] = drive_instants(drive)
    assert instant.frames == (0, 5, 10)
    assert [scan.time for scan in instant.scans] == pytest.approx([-0.5, 0.0, 0.5])
    assert instant.poses_by == "oxts"
    assert instant.id == "2026_01_01_drive_0001_sync/0000000005"
    places = np.concatenate(
        [transform_points(scan.pose, scan.points[:, :3]) for scan in instant.scans]
    )
    assert places == pytest.approx(np.tile(instant.scans[1].points[0, :3], (3, 1)), abs=2e-3)
    assert instant.scans[1].pose == pytest.approx(np.eye(4))
    # 0.8 m ahead and some to the left every tenth of a second, 0.04 rad to the left.
    sweep = instant.scans[0].sweep
    assert 8.0 < sweep.speed < 9.5
    assert sweep.turn_rate == pytest.approx(0.4, abs=0.01)


def test_without_measurements_poses_are_registered_or_refused(tmp_path: Path) -> None:
    folder = _drive(tmp_path)
    (folder / "oxts" / "data" / "0000000005.txt").unlink()
    drive = KittiRaw(folder).drive("0001")
    # A scan of one point has no surface.
    with pytest.raises(DataError, match="Frames 0, 5, 10") as caught:
        next(drive_instants(drive))
    assert "drive_0001" in str(caught.value)
    with pytest.raises(DataError, match="oxts"):
        next(drive_instants(drive, poses_by="oxts"))


def test_intervals_that_a_drive_lacks_are_refused(tmp_path: Path) -> None:
    drive = KittiRaw(_drive(tmp_path)).drive("0001")
    assert len(list(drive_instants(drive, vehicles=2, apart=1))) == 5
    with pytest.raises(DataError, match="no 3 scans"):
        next(drive_instants(drive, apart=6))
    with pytest.raises(ConfigurationError):
        next(drive_instants(drive, vehicles=1))


def test_no_frame_is_in_two_groups() -> None:
    assert spaced_groups((0, 1, 2, 5, 6, 10, 11, 20), 3, 5) == [(0, 5, 10), (1, 6, 11)]


@pytest.mark.skipif(not _REAL.exists(), reason="no KITTI raw in ../shared")
@pytest.mark.slow
def test_real_scans_half_a_second_apart_are_registered_smoothly() -> None:
    instants = list(drive_instants(KittiRaw(_REAL).drive("0052")))
    assert [instant.frames for instant in instants] == [(0, 5, 10), (15, 20, 25), (30, 35, 40)]
    for instant in instants:
        assert instant.poses_by == "registration"
        for each in instant.registrations:
            assert each is None or (each.residual < 0.03 and each.overlap > 0.5)
        before, _, after = (scan.pose for scan in instant.scans)
        # A car in dense traffic, which brakes: ahead all the time, and ever less.
        assert 0 < after[0, 3] < -before[0, 3] < 1.5
        for pose in (before, after):
            assert np.abs(pose[1:3, 3]).max() < 0.05
            assert np.degrees(np.abs(pose[:3, :3] - np.eye(3)).max()) < 0.5
