"""Bogus returns: a plane on the road, on the LiDAR's own beams, in view; what is behind is lost."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import OpticalAttack, TamperedFrame
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import project, transform_points
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.rig import camera_rig, kitti_rig

RIG = kitti_rig()
SENSOR = RIG.velodyne_pose[:3, 3]


def frame_of(points: int = 3000, width: int = 1242) -> SensorFrame:
    random = np.random.default_rng(0)
    scan = random.uniform((-20, -30, -1.7, 0), (40, 30, 3, 1), (points, 4)).astype(np.float32)
    return SensorFrame("0", RIG.calibration, {2: np.zeros((375, width, 3), np.uint8)}, scan)


def in_vehicle(points: np.ndarray) -> np.ndarray:
    return transform_points(RIG.velodyne_pose, points[:, :3])


def plane(tampered: TamperedFrame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middle of the foot, unit vector away from the LiDAR, unit vector to the left."""
    distance, bearing = tampered.settings["distance"], tampered.settings["bearing"]
    away = np.array([np.cos(bearing), np.sin(bearing), 0.0])
    return SENSOR * [1, 1, 0] + distance * away, away, np.array([-away[1], away[0], 0.0])


def test_a_plane_of_the_thesis_that_stands_on_the_road() -> None:
    for seed in range(20):
        tampered = LidarSpoofing().attack(frame_of(), seed)
        foot, away, left = plane(tampered)
        offset = in_vehicle(tampered.frame.points[tampered.points]) - foot
        across, depth, up = offset @ left, offset @ away, offset[:, 2]
        # The ranges are good to a centimetre; neighbouring beams are up to 0.1 m apart there.
        assert np.abs(depth).max() < 0.06
        assert -1.3 < across.min() < -1.2
        assert 1.2 < across.max() < 1.3
        assert -0.03 < up.min() < 0.12
        assert 1.4 < up.max() < 1.53
        assert 6 <= tampered.settings["distance"] <= 10


@pytest.mark.parametrize("distance", [6.0, 10.0])
def test_as_many_points_as_beams_meet_it(distance: float) -> None:
    attack = LidarSpoofing(distance=distance, bearing=0.1)
    elevations = [*np.linspace(2.4, -7.8, 32), *np.linspace(-8.35, -23.6, 32)]
    expected = 0
    for elevation in np.radians(elevations):
        for turned in np.radians(np.arange(-10, 22, 360 / 2007)):
            cos = np.cos(elevation)
            beam = [cos * np.cos(turned), cos * np.sin(turned), np.sin(elevation)]
            x, y, z = RIG.velodyne_pose[:3, :3] @ beam
            off = np.arctan2(y, x) - 0.1
            along_ground = distance / np.cos(off)
            up = SENSOR[2] + along_ground * z / np.hypot(x, y)
            expected += 0 <= up <= 1.5 and abs(along_ground * np.sin(off)) <= 1.25
    # Where the pulses begin is drawn: one in a hundred more or less; a ring would be one in thirty.
    assert attack.attack(frame_of(9)).points.sum() == pytest.approx(expected, rel=0.015)


def test_points_lie_on_beams_of_the_velodyne() -> None:
    tampered = LidarSpoofing().attack(frame_of(), 5)
    x, y, z = tampered.frame.points[tampered.points, :3].astype(float).T
    elevations = np.r_[np.linspace(2.4, -7.8, 32), np.linspace(-8.35, -23.6, 32)]
    off = np.degrees(np.arctan2(z, np.hypot(x, y)))[:, None] - elevations
    assert np.abs(off).min(axis=1).max() < 1e-3
    columns = np.degrees(np.arctan2(y, x)) * 2007 / 360
    phase = np.angle(np.exp(2j * np.pi * columns).mean())
    assert np.abs(np.exp(2j * np.pi * columns) - np.exp(1j * phase)).max() < 1e-2


def test_its_whole_width_is_in_view() -> None:
    bearings = []
    for seed in range(30):
        tampered = LidarSpoofing().attack(frame_of(10), seed)
        bearings.append(tampered.settings["bearing"])
        points = tampered.frame.points[tampered.points, :3]
        in_camera = transform_points(RIG.calibration.velodyne_to_camera, points)
        pixels, depth = project(RIG.calibration.projection(2), in_camera)
        assert (depth > 3).all()
        # A range that is off by a centimetre moves a point by a pixel or two.
        assert pixels[:, 0].min() > -3
        assert pixels[:, 0].max() < 1244
        assert pixels[:, 1].min() > 0
    assert min(bearings) < -0.4
    assert max(bearings) > 0.4


def test_what_is_behind_it_is_lost_and_nothing_else() -> None:
    frame = frame_of()
    tampered = LidarSpoofing(rays_lost=True, distance=8.0, bearing=0.3).attack(frame, 2)
    foot, _, left = plane(tampered)
    lost = np.zeros(len(frame.points), bool)
    for number, point in enumerate(in_vehicle(frame.points)):
        # sensor + t (point - sensor) = foot + across left + up z
        system = np.stack([point - SENSOR, -left, [0, 0, -1]], axis=1)
        t, across, up = np.linalg.solve(system, foot - SENSOR)
        lost[number] = 0 < t < 1 and abs(across) <= 1.25 and 0 <= up <= 1.5
    assert lost.sum() > 30
    np.testing.assert_array_equal(tampered.lost, lost)
    kept = tampered.frame.points[~tampered.points]
    np.testing.assert_array_equal(kept, frame.points[~lost])


def test_in_the_thesis_points_are_added() -> None:
    frame = frame_of()
    added, instead = (LidarSpoofing(rays_lost=lost).attack(frame, 2) for lost in (False, True))
    assert added.lost is None
    np.testing.assert_array_equal(added.frame.points[: len(frame.points)], frame.points)
    assert not added.points[: len(frame.points)].any()
    assert added.points[len(frame.points) :].all()
    assert (added.frame.points[added.points, 3] == np.float32(0.3)).all()
    # Both draw the same bogus points.
    np.testing.assert_array_equal(
        added.frame.points[added.points], instead.frame.points[instead.points]
    )


def test_the_seed_decides_and_nothing_else_is_touched() -> None:
    frame = frame_of()
    before = frame.points.copy()
    one, two, other = (LidarSpoofing(rays_lost=True).attack(frame, seed) for seed in (3, 3, 4))
    assert one.frame.points.tobytes() == two.frame.points.tobytes()
    assert one.frame.points.tobytes() != other.frame.points.tobytes()
    assert one.frame.points.dtype == np.float32
    np.testing.assert_array_equal(frame.points, before)
    assert one.frame.image(2) is frame.image(2)
    assert one.attacked == LidarSpoofing().sensors == {"lidar"}
    assert isinstance(LidarSpoofing(), OpticalAttack)


def test_a_given_bearing_needs_no_camera() -> None:
    frame = SensorFrame("0", RIG.calibration, {}, frame_of(10).points)
    assert LidarSpoofing(bearing=3.0).attack(frame).settings["bearing"] == 3.0
    with pytest.raises(DataError, match="camera 2"):
        LidarSpoofing().attack(frame)
    with pytest.raises(DataError, match="no LiDAR"):
        LidarSpoofing().attack(SensorFrame("0", RIG.calibration))


@pytest.mark.parametrize("bearing", [-0.4, 0.0, 0.3, 3.0])
def test_the_plane_stands_where_it_is_given(bearing: float) -> None:
    """As the LiDAR sees it: by the points alone, not by what the attack states of itself."""
    frame = SensorFrame("0", RIG.calibration, {}, frame_of(10).points)
    tampered = LidarSpoofing(distance=8.0, bearing=bearing).attack(frame)
    x, y = tampered.frame.points[tampered.points][:, :2].T
    middle = np.array([np.ptp(x) / 2 + x.min(), np.ptp(y) / 2 + y.min()])
    assert np.arctan2(middle[1], middle[0]) == pytest.approx(bearing, abs=np.radians(1.0))
    assert np.hypot(*middle) == pytest.approx(8.0, abs=0.1)


def test_other_cameras_and_image_sizes() -> None:
    rig = camera_rig([0.0, 0.3, 0.6], focal_length=360.0, centre=(310, 90), size=(621, 188))
    image = np.zeros((188, 621, 3), np.uint8)
    frame = SensorFrame("0", rig.calibration, {1: image}, np.ones((1, 4), np.float32))
    for seed in range(20):
        tampered = LidarSpoofing(reference=1).attack(frame, seed)
        points = tampered.frame.points[tampered.points, :3]
        in_camera = transform_points(rig.calibration.velodyne_to_camera, points)
        columns = project(rig.calibration.projection(1), in_camera)[0][:, 0]
        assert columns.min() > -2
        assert columns.max() < 622


def test_a_view_too_narrow_is_an_error() -> None:
    with pytest.raises(ConfigurationError, match="nowhere sees the whole width"):
        LidarSpoofing(width=30.0).attack(frame_of())
    with pytest.raises(ConfigurationError, match="nowhere sees the whole width"):
        LidarSpoofing().attack(frame_of(width=200))


@pytest.mark.parametrize(
    "bad",
    [
        {"width": 0},
        {"height": -1},
        {"distance": (9, 6)},
        {"distance": 0},
        {"bearing": np.nan},
        {"reflectance": 2},
    ],
)
def test_what_cannot_be_is_refused(bad: dict[str, Any]) -> None:
    with pytest.raises(ConfigurationError):
        LidarSpoofing(**bad)


def test_on_a_real_scan_it_stands_on_the_road(shared: Path) -> None:
    frame = KittiObject(shared / "kitti" / "object").frame("000107")
    tampered = LidarSpoofing(rays_lost=True, distance=8.0, bearing=0.0).attack(frame)
    pose = frame.calibration.velodyne_to_camera
    bogus = transform_points(pose, tampered.frame.points[tampered.points, :3])
    x, y, z = transform_points(pose, frame.points[:, :3]).T
    road = np.median(y[(np.abs(x) < 1.2) & (z > 7) & (z < 7.8)])
    assert bogus[:, 1].max() == pytest.approx(road, abs=0.15)
    # As dense as the scan itself: as many beams meet it as met what it hides, but for the sky.
    assert 0.8 < tampered.points.sum() / tampered.lost.sum() < 1.25
