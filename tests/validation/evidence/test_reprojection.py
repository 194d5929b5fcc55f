"""Depth and images carried between cameras of a row."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import project
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.rig import camera_rig
from avsec_gym.validation.evidence.reprojection import back_projected, carried_depth, carried_image

RIG = camera_rig([0.0, 0.5], focal_length=200.0, centre=(60.0, 20.0), size=(120, 40)).calibration
WALL = np.full((40, 120), 10.0, np.float32)
"""Ten pixels of disparity."""


def with_post() -> np.ndarray:
    """A post 2.5 m ahead, 40 pixels of disparity, before the wall."""
    depth = WALL.copy()
    depth[:, 60:70] = 2.5
    return depth


def test_what_is_nearer_moves_farther_and_hides_what_is_behind() -> None:
    seen = carried_depth(with_post(), RIG, 0, 1)
    np.testing.assert_allclose(seen[:, 20:30], 2.5)
    # What the post hid from camera 0 is unknown.
    assert np.isnan(seen[:, 50:60]).all()
    np.testing.assert_allclose(seen[:, 30:50], 10.0)
    np.testing.assert_allclose(seen[:, 60:110], 10.0)
    assert np.isnan(seen[:, 110:]).all()


def test_an_image_is_carried_by_the_disparity() -> None:
    image = np.random.default_rng(0).integers(0, 256, (40, 120, 3), np.uint8)
    painted, believed = carried_image(image, WALL, RIG, 1, 0)
    np.testing.assert_array_equal(painted[:, 10:], image[:, :-10])
    assert believed[:, 10:].all()
    assert not believed[:, :10].any(), "out of camera 1's sight"


def test_what_the_other_camera_cannot_see_is_not_believed() -> None:
    image = np.zeros((40, 120, 3), np.uint8)
    _, believed = carried_image(image, with_post(), RIG, 1, 0)
    # The post covers columns 20 to 30 of camera 1, which would show columns 30 to 40 of the wall.
    assert not believed[:, 30:40].any()
    assert believed[:, 40:].all()


@pytest.mark.parametrize("rows", [1, -1])
def test_what_is_above_or_below_the_other_image_is_not_believed(rows: int) -> None:
    """A camera half a metre above or below: of the wall 10 m away it sees other rows."""
    projections = RIG.projections.copy()
    projections[1, 1, 3] = rows * 10.0
    above = replace(RIG, projections=projections)
    image = np.random.default_rng(0).integers(0, 256, (40, 120, 3), np.uint8)
    painted, believed = carried_image(image, WALL, above, 1, 0)
    seen, shown = (slice(39), slice(1, 40)) if rows == 1 else (slice(1, 40), slice(39))
    np.testing.assert_array_equal(painted[seen, 10:], image[shown, :-10])
    assert believed[seen, 10:].all()
    assert believed.sum() == 39 * 110


def test_back_projection_undoes_kitti_projection(shared: Path) -> None:
    frame: SensorFrame = KittiObject(shared / "kitti/object").frame("000107")
    depth = np.random.default_rng(0).uniform(2, 80, (4, 5)).astype(np.float32)
    for camera in (2, 3):
        places = back_projected(depth, frame.calibration, camera)
        pixels, ahead = project(frame.calibration.projection(camera), places)
        np.testing.assert_allclose(ahead, depth, rtol=1e-6)
        np.testing.assert_allclose(pixels[..., 0], np.tile(np.arange(5.0), (4, 1)), atol=1e-6)
