from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import project, transform_points
from avsec_gym.kitti.calibration import read_calibration, write_calibration
from avsec_gym.rig import SensorRig, camera_rig, kitti_rig, resized_rig


def test_baselines_and_intrinsics_are_those_of_kitti() -> None:
    """P_rect of 2011-09-26, as every second KITTI frame has it."""
    calibration = kitti_rig().calibration
    assert calibration.cameras == (0, 1, 2, 3)
    assert calibration.baseline(2, 3) == pytest.approx(0.53272, abs=1e-5)
    assert calibration.baseline(0, 1) == pytest.approx(0.53715, abs=1e-5)
    products = calibration.projections[:, 0, 3]
    np.testing.assert_allclose(products, [0.0, -387.5744, 44.85728, -339.5242], atol=1e-6)
    for camera in calibration.cameras:
        intrinsic = calibration.projection(camera)[:, :3]
        np.testing.assert_allclose(
            intrinsic, [[721.5377, 0, 609.5593], [0, 721.5377, 172.854], [0, 0, 1]]
        )


def test_velodyne_and_cameras_stand_to_each_other_as_in_a_real_frame(shared: Path) -> None:
    real = read_calibration(shared / "kitti/object/training/calib/000107.txt")
    offset = kitti_rig().calibration.velodyne_to_camera @ np.linalg.inv(real.velodyne_to_camera)
    assert np.abs(offset[:3, 3]).max() < 0.1
    assert np.trace(offset[:3, :3]) > 1 + 2 * np.cos(np.radians(1.5))


def test_a_calibration_file_keeps_the_rig(tmp_path: Path) -> None:
    rig = kitti_rig()
    write_calibration(tmp_path / "000000.txt", rig.calibration)
    again = SensorRig(read_calibration(tmp_path / "000000.txt"))
    for name in ("projections", "r0_rect", "tr_velo_to_cam", "tr_imu_to_velo"):
        np.testing.assert_allclose(
            getattr(again.calibration, name), getattr(rig.calibration, name), rtol=1e-12, atol=1e-15
        )
    np.testing.assert_allclose(again.velodyne_pose, rig.velodyne_pose, atol=1e-12)


def test_the_vehicle_frame_is_on_the_ground_below_camera_0() -> None:
    rig = camera_rig([0.0, 0.54])
    for camera, right in ((0, 0.0), (1, 0.54)):
        pose = rig.camera_pose(camera)
        np.testing.assert_allclose(pose[:3, 3], [0.0, -right, 1.65], atol=1e-12)
        ahead_right_down = transform_points(pose, [[0, 0, 1], [1, 0, 0], [0, 1, 0]]) - pose[:3, 3]
        np.testing.assert_allclose(
            ahead_right_down, [[1, 0, 0], [0, -1, 0], [0, 0, -1]], atol=1e-12
        )


def test_sensors_agree_on_where_a_point_is() -> None:
    """Through the velodyne and KITTI's matrices, or through the camera's pose in the vehicle."""
    rig = kitti_rig()
    in_vehicle = np.array([[12.0, -3.0, 0.5], [40.0, 10.0, 2.0], [6.0, 0.0, 0.0]])
    in_velodyne = transform_points(np.linalg.inv(rig.velodyne_pose), in_vehicle)
    in_camera_0 = transform_points(rig.calibration.velodyne_to_camera, in_velodyne)
    for camera in rig.cameras:
        pixels, depth = project(rig.calibration.projection(camera), in_camera_0)
        x, y, z = transform_points(np.linalg.inv(rig.camera_pose(camera)), in_vehicle).T
        np.testing.assert_allclose(depth, z, atol=1e-9)
        expected = 721.5377 * np.stack([x / z, y / z], axis=-1) + [609.5593, 172.854]
        np.testing.assert_allclose(pixels, expected, atol=1e-6)


def test_the_velodyne_is_level_on_the_roof_and_the_inertial_unit_in_the_boot() -> None:
    rig = kitti_rig()
    np.testing.assert_allclose(rig.velodyne_pose[:3, 3], [-0.27, 0.0, 1.73], atol=1e-12)
    np.testing.assert_allclose(rig.velodyne_pose[:3, :3], np.eye(3), atol=0.02)
    np.testing.assert_allclose(rig.imu_pose[:3, 3], [-1.08, 0.32, 0.93], atol=0.03)


def test_a_rig_without_inertial_unit_says_so() -> None:
    calibration = kitti_rig().calibration
    without = Calibration(calibration.projections, calibration.r0_rect, calibration.tr_velo_to_cam)
    with pytest.raises(ConfigurationError, match="inertial unit"):
        _ = SensorRig(without).imu_pose


@pytest.mark.parametrize(
    "wrong",
    [
        {"right_of_camera_0": []},
        {"right_of_camera_0": [0.0], "focal_length": 0.0},
        {"right_of_camera_0": [0.0], "size": (0, 375)},
    ],
)
def test_impossible_rigs_are_refused(wrong: dict) -> None:
    with pytest.raises(ConfigurationError, match="a rig has"):
        camera_rig(**wrong)


@pytest.mark.parametrize(
    "places", [[0, 0, 0, 0], [0.0, 0.54, 0.545], [0.0, 6.0], [0.0, float("nan")], [float("inf")]]
)
def test_cameras_stand_beside_each_other_on_a_car(places: list[float]) -> None:
    with pytest.raises(ConfigurationError, match="at least 10 mm from each other"):
        camera_rig(places)


def test_a_resized_rig_sees_each_point_at_the_same_place_of_its_image() -> None:
    whole, half = kitti_rig(), resized_rig(kitti_rig(), 621)
    assert half.size == (621, 188)
    assert half.calibration.baseline(2, 3) == pytest.approx(whole.calibration.baseline(2, 3))
    points = np.array([[1.0, 0.5, 8.0], [-3.0, -1.0, 20.0]])
    for camera in (2, 3):
        large, small = (
            project(rig.calibration.projection(camera), points)[0] for rig in (whole, half)
        )
        # Edges of the image, not centres of the first pixels, lie upon each other.
        np.testing.assert_allclose(small + 0.5, 0.5 * (large + 0.5), atol=1e-9)
    with pytest.raises(ConfigurationError, match="16 pixels"):
        resized_rig(kitti_rig(), 8)
