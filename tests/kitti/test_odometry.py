from __future__ import annotations

from pathlib import Path

import numpy as np
import pykitti
import pytest

from avsec_gym.errors import DataError
from avsec_gym.kitti.odometry import KittiOdometry

from .conftest import curve, write_png

CAMERAS = "".join(
    f"P{i}: 718.9 0 607.2 {x} 0 718.9 185.2 0 0 0 1 0\n"
    for i, x in enumerate((0.0, -386.1, 45.4, -337.3))
)
LIDAR = (
    "Tr: 0.0004 -0.9999 -0.0080 -0.0120 -0.0072 0.0081 -0.9999 -0.0540 "
    "0.9999 0.0005 -0.0072 -0.29\n"
)


@pytest.fixture
def odometry_root(tmp_path: Path) -> Path:
    """Sequence 03 with two frames of four cameras and scans, and its poses."""
    root = tmp_path / "dataset"
    folder = root / "sequences" / "03"
    generator = np.random.default_rng(3)
    (folder / "velodyne").mkdir(parents=True)
    (root / "poses").mkdir()
    for number in range(2):
        for camera in range(4):
            path = folder / f"image_{camera}" / f"{number:06d}.png"
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(write_png(4, 3, generator.integers(0, 255, 36, np.uint8).tobytes()))
        scan = generator.uniform(0, 1, (5, 4)).astype("<f4")
        scan.tofile(folder / "velodyne" / f"{number:06d}.bin")
    (folder / "calib.txt").write_text(CAMERAS + LIDAR)
    (folder / "times.txt").write_text("0.000000e+00\n1.038e-01\n")
    poses = curve(2)[:, :3].reshape(2, 12).tolist()
    text = "".join(" ".join(f"{value:e}" for value in pose) + "\n" for pose in poses)
    (root / "poses" / "03.txt").write_text(text)
    return root


def test_pykitti_agrees(odometry_root: Path) -> None:
    theirs = pykitti.odometry(str(odometry_root), "03")
    for root in (odometry_root, odometry_root.parent, odometry_root / "sequences"):
        data = KittiOdometry(root)
        assert data.sequences() == ["03"]
    sequence = data.sequence("03")
    assert sequence.frames(["image_2", "velodyne"]) == [0, 1]
    for number in range(2):
        frame = sequence.frame(number)
        for camera, get in ((2, theirs.get_cam2), (3, theirs.get_cam3)):
            np.testing.assert_array_equal(frame.image(camera), np.asarray(get(number)))
        np.testing.assert_array_equal(frame.points, theirs.get_velo(number))
    assert [earlier.id for earlier in frame.previous] == ["000000"]
    np.testing.assert_array_equal(sequence.poses, theirs.poses)
    np.testing.assert_allclose(sequence.times, [time.total_seconds() for time in theirs.timestamps])
    calibration = sequence.calibration
    np.testing.assert_allclose(calibration.velodyne_to_camera, theirs.calib.T_cam0_velo)
    assert calibration.baseline() == pytest.approx(theirs.calib.b_rgb, rel=1e-4)
    np.testing.assert_array_equal(calibration.projections[2], theirs.calib.P_rect_20)


def test_calibration_of_the_image_archives_lacks_the_lidar(odometry_root: Path) -> None:
    sequence = KittiOdometry(odometry_root).sequence("03")
    (sequence.folder / "calib.txt").write_text(CAMERAS)
    with pytest.raises(DataError, match=r"lacks Tr_velo_to_cam.*data_odometry_calib.zip"):
        _ = sequence.calibration


def test_what_lacks_is_named(odometry_root: Path) -> None:
    (odometry_root / "poses" / "03.txt").unlink()
    sequence = KittiOdometry(odometry_root).sequence("03")
    with pytest.raises(DataError, match=r"sequence 03 has no poses/03.txt"):
        _ = sequence.poses
    (sequence.folder / "times.txt").write_text("0\nsoon\n")
    with pytest.raises(DataError, match=r"times.txt:2: .*not a number"):
        _ = sequence.times
    (sequence.folder / "times.txt").write_text("0\n1_000\n")  # A number in Python's source alone.
    with pytest.raises(DataError, match=r"times.txt:2: .*not a number"):
        _ = sequence.times
    with pytest.raises(DataError, match="There is no sequence 04"):
        KittiOdometry(odometry_root).sequence("04")
    with pytest.raises(DataError, match="Nothing of the KITTI odometry layout"):
        KittiOdometry(odometry_root / "poses")
