"""A turn takes a tenth of a second: who moves meanwhile, the LiDAR or others, is seen there."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.rendering.lidar import Lidar, Scan
from avsec_gym.world.rendering.light import Light
from avsec_gym.world.rendering.moving_bodies import MovingBody
from avsec_gym.world.rendering.planar_motion import PlanarMotion
from avsec_gym.world.rendering.ray_scene import RayScene, Thing
from avsec_gym.world.rendering.renderer import Renderer
from avsec_gym.world.section import Surface
from avsec_gym.world.shapes import box, polygon

pytestmark = pytest.mark.usefixtures("little_textures")

SHARP = Lidar(columns=720, noise=0.0, dropout=0.0, residual=0.0)
WHITE = Material(infrared=0.9)
GROUND = polygon([(-200, -200, 0), (200, -200, 0), (200, 200, 0), (-200, 200, 0)], WHITE)


def pose(x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> Floats:
    result = np.eye(4)
    result[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    result[:3, 3] = x, y, 1.73
    return result


def scan(*meshes: Mesh, to_world: Floats, bodies=(), compensated: bool = False) -> Scan:
    things = [Thing(mesh, Surface.VEHICLE, i) for i, mesh in enumerate(meshes)]
    renderer = Renderer(RayScene(things), Light())
    rng = np.random.default_rng(0)
    return SHARP.scan(renderer, to_world, rng, bodies=bodies, compensated=compensated)


def block(x: float, y: float, yaw: float = 0.0) -> Mesh:
    return box(4.0, 1.8, 1.5, WHITE).placed(x, y, 0.0, yaw)


def test_an_arc_ends_where_small_steps_along_it_do() -> None:
    motion = PlanarMotion(9.0, 0.8)
    x = y = yaw = 0.0
    for _ in range(20_000):
        x, y = x + 9.0 * np.cos(yaw) * 5e-5, y + 9.0 * np.sin(yaw) * 5e-5
        yaw += 0.8 * 5e-5
    np.testing.assert_allclose(motion.after(1.0), (x, y, yaw), atol=1e-3)
    np.testing.assert_allclose(motion.transforms(np.array([1.0]))[0, :2, 3], (x, y), atol=1e-3)


def test_a_turn_lasts_from_half_a_period_before_to_half_a_period_after() -> None:
    """The head turns to the left and faces ahead in the middle."""
    azimuth, times = SHARP.head, SHARP.firing_times
    assert times[0] == 0.0
    assert times.min() == pytest.approx(-0.05, abs=1e-3)
    assert times.max() == pytest.approx(0.05, abs=1e-3)
    left = np.argmin(np.abs(azimuth - 0.5 * np.pi))
    assert times[left] == pytest.approx(0.025, abs=1e-3)
    assert times[np.argmin(np.abs(azimuth - 1.5 * np.pi))] == pytest.approx(-0.025, abs=1e-3)


def test_a_standing_lidar_sees_the_same_with_every_pose_written_out() -> None:
    still = scan(GROUND, block(9.0, 4.0), to_world=pose())
    turning = scan(GROUND, block(9.0, 4.0), to_world=np.repeat(pose()[None], 720, axis=0))
    np.testing.assert_array_equal(still.points, turning.points)
    standing = [MovingBody(1, (9.0, 4.0, 0.0), PlanarMotion())]
    body = scan(GROUND, block(9.0, 4.0), to_world=pose(), bodies=standing)
    np.testing.assert_allclose(body.points[:, :3], still.points[:, :3], atol=2e-3)


def test_walls_are_skewed_by_the_way_of_the_lidar() -> None:
    """Driving along a street at 10 m/s, walls across stand 10 m/s times their time nearer."""
    ends = [box(0.2, 60.0, 8.0, WHITE).placed(x, 0.0, -2.0) for x in (20.1, -20.1)]
    poses = pose() @ PlanarMotion(10.0).transforms(SHARP.firing_times)
    moving = scan(*ends, to_world=poses)
    x = moving.points[:, 0].astype(float)
    ahead = moving.object_id == 0
    np.testing.assert_allclose(x[ahead], 20.0 - 10.0 * moving.seconds[ahead], atol=2e-3)
    np.testing.assert_allclose(x[~ahead], -20.0 - 10.0 * moving.seconds[~ahead], atol=2e-3)
    assert np.ptp(x[~ahead]) > 0.5
    # Compensated, both stand where they are at the time of the scan.
    straight = scan(*ends, to_world=poses, compensated=True)
    np.testing.assert_allclose(np.abs(straight.points[:, 0]), 20.0, atol=2e-3)


def test_a_turning_lidar_sees_a_wall_bent() -> None:
    wall = box(0.2, 60.0, 8.0, WHITE).placed(20.1, 0.0, -2.0)
    poses = pose() @ PlanarMotion(0.0, 0.5).transforms(SHARP.firing_times)
    found = scan(wall, to_world=poses)
    turned = 0.5 * found.seconds
    x, y = found.points[:, 0].astype(float), found.points[:, 1].astype(float)
    np.testing.assert_allclose(np.cos(turned) * x - np.sin(turned) * y, 20.0, atol=2e-3)


@pytest.mark.parametrize("motion", [PlanarMotion(12.0), PlanarMotion(-8.0), PlanarMotion(9.0, 1.5)])
@pytest.mark.parametrize("place", [(10.0, 3.0, 0.3), (-9.0, -4.0, 2.0), (-12.0, 0.5, 3.1)])
def test_a_moving_body_is_seen_where_it_is_then(
    motion: PlanarMotion, place: tuple[float, float, float]
) -> None:
    """As in scans of scenes in which it stands at each of those places."""
    swept = scan(GROUND, block(*place), to_world=pose(), bodies=[MovingBody(1, place, motion)])
    own = swept.object_id == 1
    assert own.sum() > 100
    # On the moved body's own surface: in its frame at each time, every point lies on the box.
    ahead, left, turned = motion.after(swept.seconds[own])
    cos, sin = np.cos(place[2]), np.sin(place[2])
    x = place[0] + ahead * cos - left * sin
    y = place[1] + ahead * sin + left * cos
    away = swept.points[own, :2] - np.stack([x, y], axis=-1)
    cos, sin = np.cos(place[2] + turned), np.sin(place[2] + turned)
    along, across = away[:, 0] * cos + away[:, 1] * sin, away[:, 1] * cos - away[:, 0] * sin
    outside = np.maximum(np.abs(along) - 2.0, np.abs(across) - 0.9)
    top = np.abs(swept.points[own, 2] + 1.73 - 1.5)
    assert np.minimum(np.abs(outside), top).max() < 3e-3
    # And all else is what is behind: every ray that leaves hits the ground or the body.
    assert set(swept.object_id) == {0, 1}
    still = scan(GROUND, to_world=pose())
    assert len(still.points) - 40 < len(swept.points) < len(still.points) + 2000
    ground = swept.points[~own]
    np.testing.assert_allclose(ground[:, 2], -1.73, atol=2e-3)


def test_where_a_body_no_longer_is_the_wall_behind_it_is_seen() -> None:
    wall = box(0.2, 60.0, 8.0, WHITE).placed(-20.1, 0.0, -2.0)
    place = (-8.0, 0.0, 0.5 * np.pi)
    fast = [MovingBody(1, place, PlanarMotion(60.0))]
    swept = scan(wall, block(*place), to_world=pose(), bodies=fast)
    # Behind, the left side is seen last: 3 m farther to the left; the right side before.
    own = swept.points[swept.object_id == 1]
    assert len(own) == 0 or np.abs(own[:, 1]).min() > 0.5
    behind = swept.points[(swept.object_id == 0) & (np.abs(swept.points[:, 1]) < 1.0)]
    np.testing.assert_allclose(behind[:, 0], -20.0, atol=2e-3)
    assert len(behind) > 100
