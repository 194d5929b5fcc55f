"""Road and side area in both images: against a scene whose geometry is known."""

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.attacks.side_area import (
    EVERYTHING,
    GROUND,
    read_roadside,
    roadside_of_surfaces,
    straight_roadside,
)
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import project, transform_points
from avsec_gym.kitti.map_files import write_disparity, write_mask
from avsec_gym.rig import kitti_rig
from avsec_gym.world.section import Surface

CALIBRATION = kitti_rig().calibration
PARALLAX = CALIBRATION.focal_length() * CALIBRATION.baseline()


def frame(scan=None) -> SensorFrame:
    image = np.full((375, 1242, 3), 90, np.uint8)
    return SensorFrame("000000", CALIBRATION, {2: image, 3: image}, scan)


def street(rows=40, columns=120):
    """A road between verges under the sky, with a post 20 pixels of disparity near in front."""
    surface = np.full((rows, columns), Surface.SKY)
    surface[10:] = Surface.VERGE
    surface[10:, 40:80] = Surface.ROAD
    disparity = np.zeros((rows, columns), np.float32)
    disparity[10:] = np.arange(2, rows - 8, dtype=np.float32)[:, None] / 4
    surface[5:30, 60:64], disparity[5:30, 60:64] = Surface.FURNITURE, 20
    return surface, disparity


def test_the_right_view_shows_what_the_left_one_does_shifted_by_its_disparity():
    surface, disparity = street()
    disparity[surface == Surface.SKY] = np.nan
    side = roadside_of_surfaces(surface, disparity)
    row = 35  # 6.75 pixels of disparity: the road's edges fall at 33.25 and 73.25.
    assert np.flatnonzero(side.right.road[row])[[0, -1]].tolist() == [33, 72]
    assert side.left.road[row].sum() == side.right.road[row].sum() == 40
    np.testing.assert_array_equal(side.right.disparity[row], 6.75)


def test_what_is_near_hides_what_is_far_and_uncovers_more_of_it():
    surface, disparity = street()
    side = roadside_of_surfaces(surface, disparity)
    row = 25
    assert side.right.side[row, 40:44].all()  # The post, 60 - 20.
    assert (side.right.disparity[row, 40:44] == 20).all()
    behind = 60 - disparity[row, 0]  # Where the road that it hid in the left view comes to light.
    shown = slice(int(np.ceil(behind)), int(behind + 4))
    assert side.right.road[row, shown].all()
    assert (side.right.disparity[row, shown] == disparity[row, 0]).all()


def test_beside_a_thin_post_comes_what_is_behind_it():
    """What only the right view sees there continues the background, not the post."""
    surface = np.full((3, 120), Surface.VERGE)
    disparity = np.full((3, 120), 4, np.float32)
    disparity[:, 44:59] = 0  # Unknown to the left of the post.
    surface[:, 59], disparity[:, 59] = Surface.FURNITURE, 20
    side = roadside_of_surfaces(surface, disparity, GROUND)
    assert not side.right.side[:, 39].any()  # The post, 59 - 20.
    assert side.right.side[:, 40:56].all()
    np.testing.assert_array_equal(side.right.disparity[:, 40:56], 4)


def test_the_right_edge_continues_what_is_next_to_it():
    surface = np.full((3, 120), Surface.VERGE)
    disparity = np.full((3, 120), 1, np.float32)
    disparity[:, 60:] = 8
    side = roadside_of_surfaces(surface, disparity)
    np.testing.assert_array_equal(side.right.disparity[:, -8:], 8)


def test_the_sky_and_what_stands_there_are_no_ground():
    surface, disparity = street()
    everything, ground = (
        roadside_of_surfaces(surface, disparity, which) for which in (EVERYTHING, GROUND)
    )
    assert everything.left.side[25, 61]
    assert not ground.left.side[25, 61]
    for view in (everything.left, everything.right):
        assert not (view.road | view.side)[:5].any()


def test_maps_are_read_and_refused(tmp_path):
    surface, disparity = street()
    for kind in ("surface_2", "disparity_2"):
        (tmp_path / kind).mkdir()
    write_mask(tmp_path / "surface_2" / "000001.png", surface.astype(np.uint8))
    write_disparity(tmp_path / "disparity_2" / "000001.png", disparity)
    side = read_roadside(tmp_path, "000001")
    np.testing.assert_array_equal(side.left.road, surface == Surface.ROAD)
    write_disparity(tmp_path / "disparity_2" / "000001.png", disparity[1:], overwrite=True)
    with pytest.raises(DataError, match="shape"):
        read_roadside(tmp_path, "000001")


def test_a_straight_road_of_a_real_frame_has_the_width_it_is_given():
    side = straight_roadside(frame(), road=(-3.0, 5.0))
    p = CALIBRATION.projection()
    row = 300
    depth = p[1, 1] * 1.65 / (row - p[1, 2])
    columns = np.flatnonzero(side.left.road[row])
    metres = (columns[[0, -1]] - p[0, 2]) * depth / p[0, 0]
    np.testing.assert_allclose(metres, [-3, 5], atol=depth / p[0, 0])
    np.testing.assert_allclose(side.left.disparity[row], PARALLAX / depth, rtol=1e-6)
    # The right camera stands one baseline further right and sees the same road further left.
    right = np.flatnonzero(side.right.road[row])
    np.testing.assert_allclose(columns[0] - right[0], PARALLAX / depth, atol=1)
    assert not (side.left.road | side.left.side)[:170].any()


def test_objects_are_neither_road_nor_side_area():
    car = Boxes3D([[0, 1.65, 12]], [[1.5, 1.6, 4]], [-np.pi / 2], [1], ["Car"])
    side = straight_roadside(frame(), car)
    u, v = 609, int(172.9 + 721.5 * 0.8 / 12)
    assert not (side.left.road | side.left.side)[v, u]
    assert straight_roadside(frame()).left.road[v, u]


def test_a_scan_tells_the_plane_and_what_stands_on_it():
    z, x = np.meshgrid(np.linspace(5, 40, 60), np.linspace(-10, 10, 60))
    ground = np.stack([x, 1.8 + 0.01 * z, z], -1).reshape(-1, 3)
    y, x = np.meshgrid(np.linspace(-1.0, 1.8, 20), np.linspace(5, 8, 25))
    wall = np.stack([x, y, np.full_like(x, 15)], -1).reshape(-1, 3)
    points = transform_points(CALIBRATION.camera_to_velodyne, np.concatenate([ground, wall]))
    scan = np.column_stack([points, np.zeros(len(points))]).astype(np.float32)
    side = straight_roadside(frame(scan))
    p = CALIBRATION.projection()
    row = 320
    depth = p[1, 1] * 1.8 / (row - p[1, 2] - 0.01 * p[1, 1])
    assert side.left.disparity[row, 600] == pytest.approx(PARALLAX / depth, rel=0.02)
    u, v = int(p[0, 2] + p[0, 0] * 6.5 / 15), int(p[1, 2] + p[1, 1] * 1.0 / 15)
    assert not side.left.side[v, u]
    assert straight_roadside(frame()).left.side[v, u]


def scan_of(*places) -> np.ndarray:
    points = transform_points(CALIBRATION.camera_to_velodyne, np.concatenate(places))
    return np.column_stack([points, np.zeros(len(points))]).astype(np.float32)


def test_a_road_that_rises_is_no_obstacle():
    z, x = (each.ravel() for each in np.meshgrid(np.linspace(5, 40, 200), np.linspace(-3, 3, 60)))
    rising = np.column_stack([x, 1.65 - 0.05 * z, z])
    side = straight_roadside(frame(scan_of(rising)))
    (u, v), _ = (each[0] for each in project(CALIBRATION.projection(), [[0, 1.65 - 1.5, 30]]))
    assert side.left.road[int(v), int(u)]
    assert side.left.disparity[int(v), int(u)] == pytest.approx(PARALLAX / 30, rel=0.05)


def test_a_dense_hedge_does_not_lift_the_road():
    z, x = (each.ravel() for each in np.meshgrid(np.linspace(5, 34, 30), np.linspace(-4, 4, 20)))
    ground = np.column_stack([x, np.full_like(x, 1.65), z])
    hedge = np.column_stack([x + 2, np.full_like(x, 0.75), z]).repeat(4, axis=0)
    row = 300
    depth = CALIBRATION.focal_length() * 1.65 / (row - CALIBRATION.projection()[1, 2])
    side = straight_roadside(frame(scan_of(ground, hedge)))
    seen = side.left.disparity[row][side.left.disparity[row] > 0]
    np.testing.assert_allclose(seen, PARALLAX / depth, rtol=1e-3)


def test_a_bank_beside_the_road_does_not_tilt_it():
    """What lies 8 m aside or more is no road, however dense its points and near its height."""
    z, x = (each.ravel() for each in np.meshgrid(np.linspace(5, 34, 60), np.linspace(-4, 4, 20)))
    ground = np.column_stack([x, np.full_like(x, 1.65), z])
    bank = np.column_stack([np.sign(x) * 9 + x, 1.65 - 0.01 * z, z]).repeat(4, axis=0)
    row = 300
    depth = CALIBRATION.focal_length() * 1.65 / (row - CALIBRATION.projection()[1, 2])
    side = straight_roadside(frame(scan_of(ground, bank)))
    assert side.left.disparity[row, 600] == pytest.approx(PARALLAX / depth, rel=1e-3)


def test_disparities_are_those_of_the_calibration():
    """Points of the road, projected into both views of cameras that are not quite level."""
    projections = CALIBRATION.projections.copy()
    projections[3][:, 3] += projections[3][:, :3] @ [0.0, 0.05, -0.03]
    projections[2][2, 3] = 0.02
    tilted = replace(CALIBRATION, projections=projections)
    image = np.full((375, 1242, 3), 90, np.uint8)
    side = straight_roadside(SensorFrame("000000", tilted, {2: image, 3: image}))
    x, z = (each.ravel() for each in np.meshgrid(np.linspace(-3, 3, 7), np.linspace(7, 40, 9)))
    road = np.column_stack([x, np.full_like(x, 1.65), z])
    left, right = (project(tilted.projection(camera), road)[0] for camera in (2, 3))
    for view, seen in ((side.left, left), (side.right, right)):
        # Between the pixels around a point: the disparity is linear along the plane's rows.
        first = seen.astype(int)
        u, v = first.T
        across, down = (seen - first).T
        corners = [view.disparity[v + j, u + i] for j in (0, 1) for i in (0, 1)]
        weights = [(1 - across), across, (1 - across), across]
        upper, lower = (
            weights[2 * j] * corners[2 * j] + weights[2 * j + 1] * corners[2 * j + 1]
            for j in (0, 1)
        )
        found = (1 - down) * upper + down * lower
        np.testing.assert_allclose(found, left[:, 0] - right[:, 0], atol=0.01)


def test_a_road_without_width_is_refused():
    with pytest.raises(ConfigurationError, match="road"):
        straight_roadside(frame(), road=(3.0, -3.0))
