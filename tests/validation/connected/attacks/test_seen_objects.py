"""Objects that a scan shows: poses, boxes, and the points in them, by brute force."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from avsec_gym.validation.connected.attacks.seen_objects import points_in_box, upright_pose


@pytest.mark.parametrize("seed", range(6))
def test_points_in_a_box_are_those_of_its_own_frame(seed: int) -> None:
    rng = np.random.default_rng(seed)
    height, width, length = rng.uniform(1.0, 5.0, 3)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("zyx", rng.uniform(-1, 1, 3) * (3.0, 0.4, 0.4)).as_matrix()
    pose[:3, 3] = rng.uniform(-10, 10, 3)
    places = pose[:3, 3] + rng.uniform(-4, 4, (3000, 3))
    along, across, up = ((places - pose[:3, 3]) @ pose[:3, :3]).T
    inside = (abs(along) <= length / 2) & (abs(across) <= width / 2) & (up > 0.2) & (up <= height)
    assert inside.any()
    assert points_in_box(places, pose, (height, width, length), feet=0.2) == inside.sum()


def test_an_upright_pose_turns_about_the_vertical_alone() -> None:
    pose = upright_pose(1.0, 2.0, 3.0, 0.5)
    expected = Rotation.from_euler("z", 0.5).as_matrix()
    np.testing.assert_allclose(pose[:3, :3], expected)
    np.testing.assert_allclose(pose[:, 3], [1, 2, 3, 1])
