from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.geometry import project, transform_points
from avsec_gym.kitti.calibration import read_calibration, write_calibration
from avsec_gym.perception.stereo_batch import batch_of_frames


@pytest.fixture
def path(object_root: Path) -> Path:
    return object_root / "training" / "calib" / "000000.txt"


def test_a_rig_by_hand(path: Path) -> None:
    calibration = read_calibration(path)
    assert calibration.cameras == (0, 1, 2, 3)
    assert calibration.focal_length() == 700
    assert calibration.baseline() == pytest.approx((42 + 336) / 700)
    assert calibration.baseline(0, 1) == pytest.approx(0.54)
    assert calibration.tr_imu_to_velo is None
    # A point 10 m ahead of the LiDAR is 9.73 m ahead of camera 0, and 8 cm higher than it.
    point = transform_points(calibration.velodyne_to_camera, [[10.0, 0.0, 0.0]])
    np.testing.assert_allclose(point, [[0.0, -0.08, 9.73]])
    back = transform_points(calibration.camera_to_velodyne, point)
    np.testing.assert_allclose(back, [[10, 0, 0]], atol=1e-12)


def test_disparity_is_focal_length_times_baseline_by_depth(path: Path) -> None:
    calibration = read_calibration(path)
    point = [[1.0, 1.5, 20.0]]
    left, depth = project(calibration.projection(2), point)
    right, _ = project(calibration.projection(3), point)
    disparity = left[0, 0] - right[0, 0]
    expected = calibration.focal_length() * calibration.baseline() / depth[0]
    assert disparity == pytest.approx(expected)


def test_a_pair_whose_right_camera_stands_to_the_left_is_refused(path: Path) -> None:
    """P2 and P3 exchanged."""
    exchanged = path.read_text().replace("P2:", "Q:").replace("P3:", "P2:").replace("Q:", "P3:")
    path.write_text(exchanged)
    image = np.zeros((3, 4, 3), np.uint8)
    frame = SensorFrame("000000", read_calibration(path), {2: image, 3: image})
    with pytest.raises(DataError, match="left camera first"):
        frame.stereo()
    with pytest.raises(DataError, match="left camera first"):
        batch_of_frames([frame])


def test_the_camera_centre_projects_to_nothing(path: Path) -> None:
    calibration = read_calibration(path)
    for camera in range(4):
        homogeneous = np.append(calibration.camera_centre(camera), 1.0)
        np.testing.assert_allclose(calibration.projection(camera) @ homogeneous, 0, atol=1e-9)


def test_an_absent_camera_is_refused(path: Path) -> None:
    calibration = read_calibration(path)
    projections = calibration.projections.copy()
    projections[1] = 0
    partial = replace(calibration, projections=projections)
    assert partial.cameras == (0, 2, 3)
    for camera in (1, 4, -1):
        with pytest.raises(ConfigurationError, match="not calibrated"):
            partial.projection(camera)


BROKEN = {
    "missing key": (lambda text: text.replace("R0_rect", "R9"), "lacks R0_rect", 7),
    "missing camera": (lambda text: text.replace("P1:", "Q1:"), "lacks P1", 7),
    "gap between cameras": (lambda text: text + "P5: " + "1 " * 12, "lacks P4", 8),
    "empty": (lambda text: "", "lacks P0", 1),
    "wrong count": (lambda text: text.replace(" 600 42", " 42"), "has 12 entries, this one 11", 3),
    "not a number": (lambda text: text.replace("-378", "-378m"), "not a number", 2),
    "not finite": (lambda text: text.replace("-378", "nan"), "not finite", 2),
    "absurd": (lambda text: text.replace("-378", "1e12"), "too large", 2),
    "twice": (lambda text: text + text.splitlines()[0], "line 1 already", 7),
    "no rotation": (lambda text: text.replace("1 0 0 0 1 0 0 0 1\n", "0 " * 9), "entries", 5),
    "zero rotation": (
        lambda text: text.replace("t: 1 0 0 0 1 0 0 0 1", "t:" + " 0" * 9),
        "not a rotation",
        5,
    ),
    "mirror": (
        lambda text: text.replace("t: 1 0 0 0 1 0 0 0 1", "t: -1 0 0 0 1 0 0 0 1"),
        "not a rotation",
        5,
    ),
    "negative focal length": (lambda text: text.replace("P2: 700", "P2: -700"), "P2 has focal", 3),
    "no focal length": (lambda text: text.replace("P2: 700", "P2: 0"), "P2 has focal", 3),
    "telescope": (lambda text: text.replace("P2: 700", "P2: 7e7"), "P2 has focal", 3),
    "third row": (lambda text: text.replace("0 0 1 0", "0 0 2 0", 1), "P0 has a third row", 1),
    "skew": (lambda text: text.replace("P2: 700 0", "P2: 700 400"), "P2 has a skew of 400", 3),
    "sideways skew": (
        lambda text: re.sub(r"(P2: \S+ \S+ \S+ \S+) 0 ", r"\1 3 ", text),
        "P2 has a skew of 0 and 3",
        3,
    ),
    "far camera": (lambda text: text.replace("-378", "-9e6"), "P1 stands more", 2),
    "far LiDAR": (lambda text: text.replace("-0.08", "1001"), "tr_velo_to_cam moves", 6),
}


@pytest.mark.parametrize(("change", "message", "line"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_calibration_is_named(
    path: Path, change: Callable[[str], str], message: str, line: int
) -> None:
    path.write_text(change(path.read_text()))
    with pytest.raises(DataError) as caught:
        read_calibration(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")
    assert message in str(caught.value)
    assert caught.value.remedy


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text() | st.lists(st.sampled_from(["P0:", "R0_rect:", "1", "nan", "\n"])).map(" ".join))
def test_any_text_gives_a_data_error(tmp_path: Path, text: str) -> None:
    path = tmp_path / "calib.txt"
    path.write_bytes(text.encode())
    with pytest.raises(DataError):
        read_calibration(path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.floats(-90, 90), min_size=48, max_size=48), st.integers(4, 6))
def test_written_calibrations_come_back(tmp_path: Path, numbers: list[float], count: int) -> None:
    # Random focal lengths, principal points and places; the third row is what it must be.
    projections = np.array(numbers[: 8 * count]).reshape(count, 2, 4)
    third = np.broadcast_to([0.0, 0.0, 1.0, 0.01], (count, 1, 4))
    projections = np.concatenate([projections, third], axis=1)
    projections[:, 0, 0], projections[:, 1, 1] = 700 + projections[:, 0, 0], 710.0
    projections[:, 0, 1] = projections[:, 1, 0] = 0.0
    rig = Calibration(
        projections=projections,
        r0_rect=np.eye(3),
        tr_velo_to_cam=np.column_stack([np.eye(3), numbers[:3]]),
        tr_imu_to_velo=np.column_stack([np.eye(3), numbers[3:6]]),
    )
    path = tmp_path / "calib.txt"
    write_calibration(path, rig, overwrite=True)
    again = read_calibration(path)
    for name in rig.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(again, name), getattr(rig, name))


def test_nothing_is_overwritten_unasked(path: Path) -> None:
    before = path.read_bytes()
    with pytest.raises(DataError, match="exists"):
        write_calibration(path, read_calibration(path))
    assert path.read_bytes() == before


def test_real_calibrations_against_a_hand_parse(shared: Path, tmp_path: Path) -> None:
    for path in sorted((shared / "kitti/object/training/calib").iterdir())[::150]:
        calibration = read_calibration(path)
        rows = dict(line.split(": ") for line in path.read_text().strip().split("\n"))
        flat = {key: np.array([float(x) for x in row.split()]) for key, row in rows.items()}
        for camera in range(4):
            np.testing.assert_array_equal(
                calibration.projection(camera), flat[f"P{camera}"].reshape(3, 4)
            )
        rotation, translation = np.eye(4), np.eye(4)
        rotation[:3, :3] = flat["R0_rect"].reshape(3, 3)
        translation[:3] = flat["Tr_velo_to_cam"].reshape(3, 4)
        np.testing.assert_allclose(calibration.velodyne_to_camera, rotation @ translation)
        assert 0.5 < calibration.baseline() < 0.6
        write_calibration(tmp_path / "out.txt", calibration, overwrite=True)
        assert (tmp_path / "out.txt").read_bytes() == path.read_bytes()


def test_tracking_calibrations_are_read_too(shared: Path) -> None:
    paths = sorted((shared / "kitti/tracking/training/calib").iterdir())
    assert len(paths) == 21
    assert all(0.5 < read_calibration(path).baseline() < 0.6 for path in paths)


def test_the_drive_of_a_frame_has_its_calibration(shared: Path) -> None:
    """Object frame 000107's matrices are those that pykitti reads from the raw calibration."""
    pykitti_utils = pytest.importorskip("pykitti.utils")
    raw = shared / "kitti/raw/2011_09_26"
    cameras = pykitti_utils.read_calib_file(raw / "calib_cam_to_cam.txt")
    ours = read_calibration(shared / "kitti/object/training/calib/000107.txt")
    for camera in range(4):
        theirs = cameras[f"P_rect_0{camera}"].reshape(3, 4)
        np.testing.assert_allclose(ours.projection(camera), theirs, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(ours.r0_rect, cameras["R_rect_00"].reshape(3, 3), atol=1e-6)
    velodyne = pykitti_utils.read_calib_file(raw / "calib_velo_to_cam.txt")
    theirs = pykitti_utils.transform_from_rot_trans(velodyne["R"], velodyne["T"])
    np.testing.assert_allclose(ours.tr_velo_to_cam, theirs[:3], atol=1e-6)
