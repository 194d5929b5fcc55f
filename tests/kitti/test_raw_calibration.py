from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.frame import Calibration
from avsec_gym.kitti.matrix_files import read_matrices
from avsec_gym.kitti.raw_calibration import read_raw_calibration, write_raw_calibration

NAMES = ("projections", "r0_rect", "tr_velo_to_cam", "tr_imu_to_velo")


def test_any_number_of_cameras_comes_back(tmp_path: Path, rig: Calibration) -> None:
    for count in (5, 4, 3):
        folder = tmp_path / str(count)
        some = replace(rig, projections=rig.projections[:count], tr_imu_to_velo=None)
        write_raw_calibration(folder, some)
        assert not (folder / "calib_imu_to_velo.txt").exists()
        again = read_raw_calibration(folder)
        assert again.cameras == tuple(range(count))
        assert again.tr_imu_to_velo is None
        np.testing.assert_array_equal(again.projections[:count], some.projections)
    with pytest.raises(DataError, match="exists"):
        write_raw_calibration(tmp_path / "3", rig)


def test_the_unrectified_cameras_fit_the_rectified_ones(tmp_path: Path, rig: Calibration) -> None:
    """R_rect K-parallel cameras at T: a point before rectification lands where P puts it."""
    write_raw_calibration(tmp_path, rig, image_size=(12, 8))
    shapes = {"T": (3,), "R": (3, 3), "K": (3, 3)}
    file = read_matrices(tmp_path / "calib_cam_to_cam.txt", lambda name: shapes.get(name[:-3]))
    point = np.array([1.0, -2.0, 30.0])
    for camera in range(5):
        r, t, k = (file.matrices[f"{name}_{camera:02d}"] for name in "RTK")
        rectified = rig.r0_rect @ (r @ point + t)
        expected = rig.projection(camera) @ np.append(rig.r0_rect @ point, 1.0)
        np.testing.assert_allclose(k @ rectified, expected)
    assert "S_rect_04: 1.200000e+01 8.000000e+00" in (
        (tmp_path / "calib_cam_to_cam.txt").read_text().splitlines()
    )


def test_kittis_own_lines_come_out_as_they_were(shared: Path, tmp_path: Path) -> None:
    source = shared / "kitti/raw/2011_09_26"
    write_raw_calibration(tmp_path, read_raw_calibration(source))
    for name in ("calib_velo_to_cam.txt", "calib_imu_to_velo.txt"):
        ours, theirs = ((f / name).read_text().splitlines()[1:] for f in (tmp_path, source))
        assert ours == theirs
    theirs = (source / "calib_cam_to_cam.txt").read_text().splitlines()
    written = (tmp_path / "calib_cam_to_cam.txt").read_text().splitlines()
    for key in ("P_rect_00", "P_rect_03", "R_rect_00", "S_rect_02"):
        (line,) = (line for line in theirs if line.startswith(key))
        assert line in written
    keys = [line.split(":")[0] for line in theirs]
    assert [line.split(":")[0] for line in written] == keys


CAMERAS, VELODYNE, IMU = "calib_cam_to_cam.txt", "calib_velo_to_cam.txt", "calib_imu_to_velo.txt"
BROKEN = {
    "cut off": (
        CAMERAS,
        lambda text: text[: text.index("R_rect_02")],
        "lacks P_rect_02, P_rect_03",
    ),
    "no R_rect_00": (CAMERAS, lambda text: text.replace("R_rect_00", "R_rect"), "lacks R_rect_00"),
    "empty": (VELODYNE, lambda _: "", "lacks R, T"),
    "short": (IMU, lambda text: text[:-14], r":3: T has 3 entries, this one 2"),
    "word": (VELODYNE, lambda text: text.replace("T: ", "T: x"), r":3: T holds"),
    "NaN": (VELODYNE, lambda text: text.replace("T: ", "T: nan "), "entries"),
    "infinite": (CAMERAS, lambda text: text.replace("7.000000e+01", "inf"), "not finite"),
    "twice": (IMU, lambda text: text + text, r":5: R stands in line 2 already"),
    "no rotation": (
        VELODYNE,
        lambda text: text.replace("R: -0.0", "R: 0.9"),
        r":2: .*not a rotation",
    ),
}


@pytest.mark.parametrize(("name", "change", "message"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_file_is_named(  # type: ignore[no-untyped-def]
    tmp_path: Path, rig: Calibration, name: str, change, message: str
) -> None:
    write_raw_calibration(tmp_path, rig)
    path = tmp_path / name
    path.write_text(change(path.read_text()))
    with pytest.raises(DataError, match=message) as caught:
        read_raw_calibration(tmp_path)
    assert caught.value.path == str(path)
    assert caught.value.line
    assert caught.value.remedy


def test_what_is_missing_is_named(tmp_path: Path, rig: Calibration) -> None:
    write_raw_calibration(tmp_path, rig)
    (tmp_path / VELODYNE).unlink()
    with pytest.raises(DataError, match=VELODYNE):
        read_raw_calibration(tmp_path)
    (tmp_path / CAMERAS).unlink()
    with pytest.raises(DataError, match=f"no {CAMERAS}.*download"):
        read_raw_calibration(tmp_path)
