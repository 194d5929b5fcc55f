"""Objects that a scan shows: poses, boxes, and the points in them, by brute force."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from avsec_gym.validation.connected.attacks.seen_objects import (
    SeenObject,
    box_in_world,
    points_in_box,
    seen_objects,
    upright_pose,
)
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.vehicle_scan import VehicleScan


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


@pytest.mark.parametrize("heading", [0.0, 1.1])
@pytest.mark.parametrize(
    ("place", "inside"),
    [
        ((1.999, 0.0, 0.8), True),
        ((2.001, 0.0, 0.8), False),
        ((-1.999, 0.0, 0.8), True),
        ((-2.001, 0.0, 0.8), False),
        ((0.0, 0.999, 0.8), True),
        ((0.0, 1.001, 0.8), False),
        ((0.0, -0.999, 0.8), True),
        ((0.0, -1.001, 0.8), False),
        ((0.0, 0.0, 1.499), True),
        ((0.0, 0.0, 1.501), False),
        ((0.0, 0.0, 0.101), True),
        ((0.0, 0.0, 0.099), False),
    ],
)
def test_a_point_is_in_a_box_up_to_its_sides_and_not_at_its_feet(
    heading: float, place: tuple[float, float, float], inside: bool
) -> None:
    pose = upright_pose(7.0, -4.0, 0.5, heading)
    point = (pose @ [*place, 1.0])[None, :3]
    assert points_in_box(point, pose, (1.5, 2.0, 4.0)) == inside


def test_the_top_and_the_sides_belong_to_a_box_and_its_feet_do_not() -> None:
    places = np.array([[2.0, 1.0, 1.5], [-2.0, -1.0, 0.25], [0.0, 0.0, 0.125]])
    pose = np.eye(4)
    assert [points_in_box(places[:n], pose, (1.5, 2.0, 4.0), 0.125) for n in range(4)] == [
        0,
        1,
        2,
        2,
    ]


def _boxes_of(*places: tuple[float, float, float]) -> RecordedInstant:
    """Points on the upright sides of boxes of 3.8 x 1.6 x 1.4 m, on flat ground."""
    sides = [np.zeros((0, 3))]
    for x, y, heading in places:
        u = np.linspace(-1, 1, 24)
        around = np.concatenate([np.c_[1.9 * u, 0 * u - 0.8], np.c_[0 * u - 1.9, 0.8 * u]])
        # A little inside, too: fitted sides go through the outermost points.
        around = np.concatenate([around, 0.95 * around])
        cos, sin = np.cos(heading), np.sin(heading)
        turned = around @ np.array([[cos, sin], [-sin, cos]]) + [x, y]
        for up in np.linspace(0.1, 1.4, 9):
            sides.append(np.c_[turned, np.full(len(turned), up - 1.73)])
    x, y = np.meshgrid(np.linspace(-40, 40, 81), np.linspace(-40, 40, 81))
    sides.append(np.c_[x.ravel(), y.ravel(), np.full(x.size, -1.73)])
    points = np.concatenate(sides)
    scan = np.c_[points, np.full(len(points), 0.4)].astype(np.float32)
    return RecordedInstant("0", (VehicleScan(scan, np.eye(4)),))


def test_without_labels_objects_are_clusters_the_nearest_first() -> None:
    instant = _boxes_of((20.0, 9.0, 0.1), (9.0, 5.0, 0.0))
    near, far = seen_objects(instant, 0)
    assert near.distance == pytest.approx(np.hypot(9.0, 5.0), abs=0.6)
    assert far.distance == pytest.approx(np.hypot(20.0, 9.0), abs=0.6)
    assert near.speed == far.speed == 0.0
    for each in (near, far):
        height, width, length = each.dimensions
        assert (height, width, length) == pytest.approx((1.4, 1.6, 3.8), abs=0.5)
        places = instant.scans[0].points[:, :3].astype(float)
        assert each.points == points_in_box(places, each.pose, each.dimensions) > 100
    assert len(seen_objects(instant, 0, fewest=max(near.points, far.points))) == 1
    assert not seen_objects(instant, 0, fewest=max(near.points, far.points) + 1)


def test_a_box_is_as_far_as_its_middle_on_the_ground_and_turns_with_the_vehicle() -> None:
    pose = upright_pose(3.0, 4.0, -1.7, 0.4)
    assert SeenObject(pose, (1.5, 1.8, 4.2), 7).distance == pytest.approx(5.0)
    region = box_in_world(pose, (1.5, 1.8, 4.2), upright_pose(10.0, 20.0, 1.7, np.pi / 2))
    assert region.centre[0] == pytest.approx([6.0, 23.0, 0.0])
    assert region.size[0] == pytest.approx([4.2, 1.8, 1.5])
    assert region.heading[0] == pytest.approx(0.4 + np.pi / 2)
