"""Known points in CARLA's left-handed frames, and where they are in ours."""

import numpy as np
import pytest

from avsec_gym.validation.connected.opv2v.carla_frames import (
    carla_transform,
    velodyne_points,
    velodyne_pose,
)


@pytest.mark.parametrize(
    ("pose", "point", "world"),
    [
        # A sensor at (10, 20) that faces CARLA's y, to its right x: what is ahead, on its right.
        ([10, 20, 2, 0, 90, 0], [5, 0, 0], [10, -25, 2]),
        ([10, 20, 2, 0, 90, 0], [0, 3, 0], [7, -20, 2]),
        # It looks up by pitch, and its right side goes down by roll.
        ([0, 0, 2, 0, 0, 30], [2, 0, 0], [2 * np.cos(np.pi / 6), 0, 3]),
        ([0, 0, 2, 30, 0, 0], [0, 2, 0], [0, -2 * np.cos(np.pi / 6), 1]),
    ],
)
def test_known_points(pose: list[float], point: list[float], world: list[float]) -> None:
    ours = velodyne_points(np.array([[*point, 0.5]], np.float32))
    pose_of_ours = velodyne_pose(pose)
    assert pose_of_ours @ [*ours[0, :3], 1] == pytest.approx([*world, 1], abs=1e-6)
    assert np.linalg.det(pose_of_ours[:3, :3]) == pytest.approx(1)
    assert ours[0, 3] == 0.5


def test_a_transform_does_as_well_as_its_numbers() -> None:
    pose = [1.0, 2.0, 3.0, 10.0, -70.0, 5.0]
    assert velodyne_pose(carla_transform(pose)) == pytest.approx(velodyne_pose(pose))
