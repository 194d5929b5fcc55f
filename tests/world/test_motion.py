"""Actors a little later, and scans that take their time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.geometry import transform_points
from avsec_gym.rig import SensorRig, camera_rig
from avsec_gym.world.capture import Sweep, render
from avsec_gym.world.drives import DriveScenes, drive_scenes
from avsec_gym.world.motion import later, moving_bodies, poses_after, with_ego_speed
from avsec_gym.world.posed_scenes import PosedScene
from avsec_gym.world.rendering.lidar import Lidar

SHARP = Lidar(columns=400, noise=0.0, dropout=0.0, residual=0.0, seed=1)


def small_rig() -> SensorRig:
    return camera_rig([0.0, 0.54], focal_length=92.9, centre=(78.2, 21.8), size=(160, 48))


@pytest.fixture(scope="module")
def scenes() -> DriveScenes:
    return drive_scenes(3, 1, 4, egos=2, rig=small_rig())


def standing(posed: PosedScene) -> PosedScene:
    """The same scene, in which nothing moves."""
    still = np.zeros(len(posed.instant.actors))
    actors = replace(posed.instant.actors, speed=still, moving=still > 0)
    return replace(posed, instant=replace(posed.instant, actors=actors, turn_rate=still))


def test_the_next_instant_is_where_speed_and_turn_rate_lead(scenes: DriveScenes) -> None:
    for frame in range(3):
        now, then = scenes[frame].instant, scenes[frame + 1].instant
        _, here, there = np.intersect1d(now.actors.id, then.actors.id, return_indices=True)
        expected, found = poses_after(now, 0.1)[here], then.actors.pose[there]
        np.testing.assert_allclose(expected[:, :2], found[:, :2], atol=0.03)
        np.testing.assert_allclose(np.sin(expected[:, 2] - found[:, 2]), 0.0, atol=1e-9)
        assert np.abs(expected[:, :2] - now.actors.pose[here, :2]).max() > 0.5
    # The last one turns, too: towards an instant that is not shown.
    turn_rate = scenes[3].instant.turn_rate
    assert turn_rate is not None
    assert (turn_rate != 0).any()


def test_a_scene_a_tenth_later_is_the_next_one(scenes: DriveScenes) -> None:
    moved, found = later(scenes[1], 0.1), scenes[2]
    assert moved.instant.time == pytest.approx(found.instant.time)
    np.testing.assert_allclose(moved.vehicle_to_world, found.vehicle_to_world, atol=0.03)
    now = scenes[1]
    assert later(now, 0.0) is now


def test_where_nothing_moves_a_rolling_scan_is_an_instantaneous_one(scenes: DriveScenes) -> None:
    posed = standing(scenes[1])
    assert not moving_bodies(posed.instant, 0)
    scans = [render(posed, cameras=(), lidar=SHARP, sweep=sweep).scan for sweep in Sweep]
    for scan in scans[1:]:
        assert scan is not None
        assert scans[0] is not None
        np.testing.assert_array_equal(scan.points, scans[0].points)


def test_a_driving_vehicle_scans_the_world_skewed_by_its_way(scenes: DriveScenes) -> None:
    """Every point of the rolling scan lies v dt from where the compensated one has it."""
    speed = 15.0
    posed = with_ego_speed(standing(scenes[1]), speed)
    rolling = render(posed, cameras=(), lidar=SHARP, sweep=Sweep.ROLLING).scan
    straight = render(posed, cameras=(), lidar=SHARP, sweep=Sweep.COMPENSATED).scan
    assert rolling is not None
    assert straight is not None
    to_vehicle = posed.rig.velodyne_pose
    own = transform_points(to_vehicle, rolling.points[:, :3].astype(float))
    at_trigger = transform_points(to_vehicle, straight.points[:, :3].astype(float))
    way = np.zeros_like(own)
    way[:, 0] = speed * rolling.seconds
    np.testing.assert_allclose(at_trigger - own, way, atol=2e-3)
    assert np.ptp(way[:, 0]) == pytest.approx(1.5, abs=0.02)


def test_who_is_overtaken_is_seen_at_its_own_time(scenes: DriveScenes) -> None:
    """The other sensor vehicle's points lie on it, wherever it is when the beam passes."""
    posed = scenes[1]
    found = render(posed, ego=0, cameras=(), lidar=SHARP, sweep=Sweep.ROLLING).scan
    assert found is not None
    bodies = moving_bodies(posed.instant, 0)
    assert bodies
    motion = {body.object_id: body for body in bodies}
    own = posed.vehicle_to_world[0] @ posed.rig.velodyne_pose
    for index in set(found.object_id.tolist()) & set(motion):
        mine = found.object_id == index
        times = found.seconds[mine].astype(float)
        own_motion = posed.instant.actors.speed[posed.instant.egos[0]] * times
        place = transform_points(own, found.points[mine, :3].astype(float))
        heading = posed.instant.actors.pose[posed.instant.egos[0], 2]
        place[:, 0] += own_motion * np.cos(heading)
        place[:, 1] += own_motion * np.sin(heading)
        x, y, turned = motion[index].pose
        ahead, left, angle = motion[index].motion.after(times)
        x = x + ahead * np.cos(turned) - left * np.sin(turned)
        y = y + ahead * np.sin(turned) + left * np.cos(turned)
        cos, sin = np.cos(turned + angle), np.sin(turned + angle)
        along = (place[:, 0] - x) * cos + (place[:, 1] - y) * sin
        across = (place[:, 1] - y) * cos - (place[:, 0] - x) * sin
        _, width, length = posed.instant.actors.dimensions[index]
        assert (np.abs(along) < 0.5 * length + 0.06).all()
        assert (np.abs(across) < 0.5 * width + 0.06).all()
