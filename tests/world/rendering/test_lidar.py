from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.geometry import project, transform_points
from avsec_gym.rig import camera_rig
from avsec_gym.world.capture import pinhole
from avsec_gym.world.material import Material
from avsec_gym.world.rendering.lidar import Lidar, Scan
from avsec_gym.world.rendering.lidar_body import free_of_body
from avsec_gym.world.rendering.light import Light
from avsec_gym.world.rendering.ray_scene import RayScene, Thing
from avsec_gym.world.rendering.renderer import Renderer
from avsec_gym.world.section import Surface
from avsec_gym.world.shapes import box, ellipsoid, polygon

pytestmark = pytest.mark.usefixtures("little_textures")

SHARP = Lidar(columns=180, noise=0.0, dropout=0.0, residual=0.0)
WHITE = Material(infrared=0.9)
GROUND = polygon([(-200, -200, 0), (200, -200, 0), (200, 200, 0), (-200, 200, 0)], WHITE)


def at(height: float = 1.73) -> np.ndarray:
    pose = np.eye(4)
    pose[2, 3] = height
    return pose


def scan(lidar: Lidar, *meshes, pose=None, seed=0, free=None) -> Scan:
    """Mesh i is object i."""
    things = [Thing(mesh, Surface.BUILDING, i) for i, mesh in enumerate(meshes)]
    renderer = Renderer(RayScene(things), Light())
    pose = at() if pose is None else pose
    return lidar.scan(renderer, pose, np.random.default_rng(seed), free)


def room(infrared: float, radius: float = 10.0):
    """A ball around the LiDAR."""
    return ellipsoid((0, 0, 0), [radius] * 3, Material(infrared=infrared), rings=120)


def test_64_beams_fall_from_two_degrees_up_to_25_down() -> None:
    lidar = Lidar()
    elevations = np.degrees(lidar.lasers.elevation)
    assert elevations.shape == (64,)
    assert 1.5 < elevations[0] < 3.0
    assert -25.5 < elevations[-1] < -23.0
    steps = -np.diff(elevations)
    assert np.median(steps[:31]) == pytest.approx(1 / 3, abs=0.06)
    assert np.median(steps[32:]) == pytest.approx(0.5, abs=0.06)
    assert 0.16 < 360 / lidar.columns < 0.19
    np.testing.assert_allclose(np.linalg.norm(lidar.directions, axis=1), 1.0, atol=1e-5)
    assert np.array_equal(Lidar().directions, lidar.directions)
    assert not np.array_equal(Lidar(seed=65).directions, lidar.directions)


def test_each_beam_turns_from_ahead_over_the_left_side() -> None:
    rays = SHARP.directions.reshape(64, 180, 3)
    azimuth = np.unwrap(np.arctan2(rays[..., 1], rays[..., 0]), axis=1)
    # The head's encoder has steps of 0.09 degrees.
    steps = np.degrees(np.diff(azimuth, axis=1)) / 0.09
    np.testing.assert_allclose(steps, np.round(steps), atol=0.01)
    np.testing.assert_allclose(steps, 2.0 / 0.09, atol=1.0)
    assert (azimuth[:, 0] > 0).all()
    assert (azimuth[:, 0] < np.radians(0.09)).all()
    elevation = np.arcsin(rays[..., 2])
    assert np.ptp(elevation, axis=1).max() < 1e-5


def test_real_scans_are_ordered_likewise(shared) -> None:
    path = shared / "kitti/object/training/velodyne/000107.bin"
    x, y, z, _ = np.fromfile(path, np.float32).reshape(-1, 4).T
    azimuth = np.arctan2(y, x)
    assert np.median(np.diff(azimuth)) > 0
    assert (np.abs(np.diff(azimuth)) > np.pi).sum() == pytest.approx(64, abs=1)
    elevation = np.degrees(np.arctan2(z, np.hypot(x, y)))
    assert elevation[:1000].mean() > 1.0
    assert elevation[-1000:].mean() < -18.0


def test_ranges_to_level_ground_are_the_height_by_the_sine() -> None:
    found = scan(SHARP, GROUND)
    points = found.points[:, :3]
    np.testing.assert_allclose(points[:, 2], -1.73, atol=1e-3)
    lasers = SHARP.lasers
    radius = np.hypot(points[:, 0], points[:, 1])
    for laser in np.flatnonzero(lasers.elevation < -np.arctan(1.94 / 40)):
        # Each ring is cut from a cone whose tip lies where the laser sits.
        expected = (1.73 + lasers.height[laser]) / np.tan(-lasers.elevation[laser])
        assert (np.abs(radius - expected) < 2e-3).sum() == 180
    # All that should return do: nothing is too dark or too far.
    assert len(points) >= 180 * (lasers.elevation < -np.arctan(1.94 / 40)).sum()


def test_points_are_in_the_frame_of_the_lidar() -> None:
    """A wall ahead of a LiDAR that is turned and tilted, 25 m north-east of the origin."""
    pose = at()
    cos, sin = np.cos(2.0), np.sin(2.0)
    pose[:3, :3] = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]) @ np.array(
        [[np.cos(0.05), 0, np.sin(0.05)], [0, 1, 0], [-np.sin(0.05), 0, np.cos(0.05)]]
    )
    pose[:2, 3] = 20.0, 15.0
    wall = box(0.2, 60.0, 40.0, WHITE).placed(20 + 12 * cos, 15 + 12 * sin, -20.0, 2.0)
    found = scan(SHARP, wall, pose=pose)
    world = transform_points(pose, found.points[:, :3])
    ahead = (world - pose[:3, 3]) @ [cos, sin, 0]
    assert len(ahead) > 2000
    np.testing.assert_allclose(ahead, 11.9, atol=1e-2)


def test_noise_and_losses_are_those_that_are_stated() -> None:
    """Noise grows as the root of 1 + (d / 20)^2."""
    lidar = Lidar(columns=360, noise=0.03, dropout=0.05, residual=0.0)
    found = scan(lidar, room(0.9), pose=np.eye(4))
    distance = np.linalg.norm(found.points[:, :3], axis=1)
    grown = 0.03 * np.sqrt(1.25)
    assert len(distance) / (64 * 360) == pytest.approx(0.95, abs=0.006)
    assert distance.mean() == pytest.approx(10.0, abs=0.01)
    assert distance.std() == pytest.approx(grown, rel=0.05)
    again = scan(lidar, room(0.9), pose=np.eye(4))
    np.testing.assert_array_equal(found.points, again.points)
    assert not np.array_equal(scan(lidar, room(0.9), pose=np.eye(4), seed=1).points, found.points)


def test_ranges_are_limited_on_both_sides() -> None:
    assert len(scan(replace(SHARP, nearest=2.0), room(0.9, 1.5), pose=np.eye(4)).points) == 0
    assert len(scan(replace(SHARP, nearest=1.0), room(0.9, 1.5), pose=np.eye(4)).points) > 9000
    assert len(scan(replace(SHARP, farthest=25.0), room(0.9, 30.0), pose=np.eye(4)).points) == 0


def test_dull_things_are_just_seen_at_50_metres() -> None:
    """Half of the pulses at the sensitivity itself, all at twice that, none far below."""

    def share(infrared: float) -> float:
        lidar = replace(SHARP, sensitivity=0.05)
        return len(scan(lidar, room(infrared, 50.0), pose=np.eye(4)).points) / (64 * 180)

    assert share(0.05) == pytest.approx(0.5, abs=0.1)
    assert share(0.1) > 0.98
    assert share(0.02) < 0.02


def test_retro_reflectors_shine() -> None:
    """A sign among walls, 12 m away."""
    signs = scan(Lidar(), room(1.0, 12.0), pose=np.eye(4)).points[:, 3]
    walls = scan(Lidar(), room(0.3, 12.0), pose=np.eye(4)).points[:, 3]
    asphalt = scan(Lidar(), room(0.1, 12.0), pose=np.eye(4)).points[:, 3]
    assert np.median(signs) > 0.75
    assert np.median(asphalt) < np.median(walls) < 0.5
    for shown in (signs, walls, asphalt):
        assert ((shown >= 0) & (shown <= 0.99)).all()
        np.testing.assert_allclose(shown * 100, np.round(shown * 100), atol=1e-3)


def test_pulses_pass_one_pane_of_glass() -> None:
    glass = Material(glass=True, infrared=0.9)

    def pane(x: float):
        return polygon([(x, 9, -9), (x, -9, -9), (x, -9, 9), (x, 9, 9)], glass)

    wall = box(0.2, 9.0, 9.0, WHITE).placed(15.0, 0.0, -4.5)
    behind = scan(SHARP, wall, pane(5.0), pose=np.eye(4))
    straight = scan(SHARP, wall, pose=np.eye(4))
    assert set(behind.object_id) == {0}
    np.testing.assert_allclose(behind.points[:, :3], straight.points[:, :3], atol=1e-3)
    assert len(scan(SHARP, wall, pane(5.0), pane(6.0), pose=np.eye(4)).points) == 0


def test_points_know_whose_they_are() -> None:
    car = box(4.0, 1.8, 1.5, WHITE).placed(12.0, 3.0, 0.0, 0.3)
    found = scan(SHARP, GROUND, car)
    on_car = transform_points(
        np.linalg.inv(_placed(12.0, 3.0, 0.3)), found.points[:, :3] + [0, 0, 1.73]
    )
    inside = (np.abs(on_car) <= np.array([2.0, 0.9, 1.5]) + 0.01).all(axis=1) & (
        on_car[:, 2] > 0.02
    )
    assert inside.sum() > 30
    np.testing.assert_array_equal(found.object_id[inside], 1)
    np.testing.assert_array_equal(found.object_id[~inside & (on_car[:, 2] < 5e-3)], 0)


def _placed(x: float, y: float, yaw: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    pose[:2, 3] = x, y
    return pose


def test_points_project_to_the_depth_that_the_camera_renders() -> None:
    """Less than a pixel of disparity apart for 99 % of the points away from edges."""
    rig = camera_rig([0.0, 0.54], focal_length=200.0, centre=(119.5, 35.5), size=(240, 72))
    rng = np.random.default_rng(0)
    meshes = [GROUND] + [
        box(2.5, 1.5, 1.5, WHITE).placed(
            rng.uniform(8, 35), rng.uniform(-8, 8), 0, rng.uniform(0, 6)
        )
        for _ in range(8)
    ]
    renderer = Renderer(
        RayScene([Thing(mesh, Surface.ROAD, i) for i, mesh in enumerate(meshes)]), Light()
    )
    geometry = renderer.geometry(pinhole(rig, 0, np.eye(4)))
    lidar = Lidar(columns=1000, residual=0.0)
    found = lidar.scan(renderer, rig.velodyne_pose, rng)
    in_camera = transform_points(rig.calibration.velodyne_to_camera, found.points[:, :3])
    pixels, depth = project(rig.calibration.projection(0), in_camera)
    u, v = np.round(np.nan_to_num(pixels)).astype(int).T
    seen = (depth > 1) & (u >= 1) & (u < 239) & (v >= 1) & (v < 71)
    u, v, depth = u[seen], v[seen], depth[seen]
    around = np.stack([geometry.depth[v + i, u + j] for i in (-1, 0, 1) for j in (-1, 0, 1)])
    smooth = np.ptp(200 * 0.54 / around, axis=0) < 0.5
    assert smooth.sum() > 1500
    error = (200 * 0.54 / depth - 200 * 0.54 / around[4])[smooth]
    # Lasers sit 0.2 to 0.3 m above the cameras and look over what hides the ground from them.
    over = error < -1.0
    assert over.mean() < 0.06
    assert (error[~over] < 1.0).mean() > 0.99
    assert np.median(np.abs(error)) < 0.15


def test_the_vehicles_own_body_hides_what_lies_close_behind_and_below() -> None:
    lidar = Lidar(columns=360)
    free = free_of_body(lidar)
    assert free.shape == (64 * 360,)
    behind, beside = 360 // 2, 360 // 4
    assert free.reshape(64, 360)[:, beside].all()
    assert not free.reshape(64, 360)[56:, behind].any()
    rays = lidar.directions.reshape(64, 360, 3)
    free = free.reshape(64, 360)
    assert free[:20].mean() > 0.97  # level ones pass above the roof
    assert 0.5 < free.mean() < 0.999
    blocked = rays[~free]
    assert (blocked[:, 2] < -0.1).mean() > 0.9
    with_mask = scan(lidar, GROUND, free=free.reshape(-1))
    without = scan(lidar, GROUND)
    assert len(with_mask.points) < len(without.points)
    nearest = np.hypot(*with_mask.points[:, :2].T).min()
    assert nearest > 2.0
