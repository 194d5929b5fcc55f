from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.kitti.drives import recorded_drives
from avsec_gym.kitti.odometry import OdometrySequence
from avsec_gym.kitti.raw import Drive
from avsec_gym.kitti.tracking_sequences import TrackingSequence
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.recordings import raw_recordings

from .test_odometry import odometry_root  # noqa: F401
from .test_tracking_sequences import tracking_root  # noqa: F401


def test_every_layout_has_drives(
    raw_root: Path,
    tracking_root: Path,  # noqa: F811
    odometry_root: Path,  # noqa: F811
) -> None:
    for root, kind, names in (
        (raw_root, Drive, ["2026_01_01_drive_0007_sync"]),
        (tracking_root, TrackingSequence, ["0004", "0011"]),
        (odometry_root, OdometrySequence, ["03"]),
    ):
        drives = recorded_drives(root)
        assert [drive.name for drive in drives] == names
        assert all(isinstance(drive, kind) for drive in drives)
    with pytest.raises(DataError, match="no such folder"):
        recorded_drives(raw_root.parent / "tracking" / "nothing")


def test_sequences_are_recordings_to_be_validated(
    tracking_root: Path,  # noqa: F811
    odometry_root: Path,  # noqa: F811
) -> None:
    found = raw_recordings(tracking_root)
    assert found.system.sensors == (LIDAR, 3, 2)
    assert [frame.id for frame in found.frames] == ["000000", "000002"]
    assert found.lacking == {"000001": "velodyne"}
    assert len(found.frames[1].read(found.system).points) == 7
    found = raw_recordings(odometry_root)
    assert found.system.sensors[0] == LIDAR
    assert len(found.system.cameras) >= 3
    assert [frame.drive for frame in found.frames] == ["03", "03"]
