"""Poses of vehicles on the ground, and drives that can be entered anywhere."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.geometry import transform_points
from avsec_gym.world.drives import STEP, drive_scenes, vehicle_poses
from avsec_gym.world.ground import Ground


def test_wheels_stand_on_a_slope() -> None:
    ground = Ground((2.0, 0.05, -0.03))
    pose = vehicle_poses(ground, np.array([[3.0, -4.0, 0.7], [0.0, 0.0, -2.0]]))
    rotation = pose[:, :3, :3]
    np.testing.assert_allclose(
        rotation @ rotation.transpose(0, 2, 1), np.tile(np.eye(3), (2, 1, 1)), atol=1e-12
    )
    assert (np.linalg.det(rotation) > 0).all()
    wheels = np.array([[1.3, 0.7, 0.0], [1.3, -0.7, 0.0], [-1.3, 0.7, 0.0], [-1.3, -0.7, 0.0]])
    for each in pose:
        x, y, z = transform_points(each, wheels).T
        np.testing.assert_allclose(z, ground.height(x, y), atol=1e-9)
    assert np.arctan2(rotation[0, 1, 0], rotation[0, 0, 0]) == pytest.approx(0.7)


def test_level_ground_turns_nothing() -> None:
    (pose,) = vehicle_poses(Ground(), np.array([[1.0, 2.0, 0.0]]))
    np.testing.assert_allclose(pose[:3, :3], np.eye(3))
    np.testing.assert_allclose(pose[:3, 3], [1.0, 2.0, 0.0])


def test_frames_of_a_drive() -> None:
    scenes = drive_scenes(3, 0, 4, egos=2)
    again = drive_scenes(3, 0, 4, egos=2)
    assert len(scenes) == 4
    assert again.world is scenes.world
    last = scenes[-1]
    assert last.built is scenes[0].built
    assert last.seed[-1] == 3
    assert last.seed[:2] == scenes[0].seed[:2]
    assert [posed.instant.time for posed in scenes] == pytest.approx([STEP * i for i in range(4)])
    assert last.vehicle_to_world.shape == (2, 4, 4)
    for ego, own in enumerate(last.instant.egos):
        actors = last.instant.actors
        place = last.vehicle_to_world[ego][:3, 3]
        np.testing.assert_allclose(place, [*actors.pose[own, :2], actors.z[own]], atol=1e-9)
    assert len({drive_scenes(3, i, 1).world.site.style for i in range(5)}) == 5
