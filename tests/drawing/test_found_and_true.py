"""Boxes are drawn where they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.found_and_true import draw_frame, draw_frames_from_above
from avsec_gym.drawing.scenario_picture import picture_array
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import project
from avsec_gym.rig import kitti_rig

ORANGE = np.array([0xD5, 0x5E, 0x00])


def box(x: float, z: float) -> Boxes3D:
    return Boxes3D(
        np.array([[x, 1.65, z]]), np.array([[1.5, 1.65, 4.0]]), np.array([-np.pi / 2]),
        np.array([0.9]), np.array(["Car"]),
    )  # fmt: skip


def where(picture: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Column and row of what is orange, as shares of the picture, shape (N, 2)."""
    rows, columns = np.nonzero(np.abs(picture.astype(int) - ORANGE).sum(-1) < 40)
    return np.column_stack([columns / picture.shape[1], rows / picture.shape[0]])


def test_a_box_is_drawn_on_what_it_means() -> None:
    black = {2: np.zeros((375, 1242, 3), np.uint8)}
    frame = SensorFrame("000000", kitti_rig().calibration, black)
    figure = draw_frame(frame, box(-3.0, 15.0), {"dsgn": box(-3.0, 15.0)})
    image = figure.axes[0].get_position()
    spots = where(picture_array(figure))
    inside = spots[(spots[:, 0] < image.x1) & (spots[:, 1] > 1 - image.y1 + 0.1)]
    middle = np.array([[-3.0, 0.9, 15.0]])
    (u, v), _ = project(kitti_rig().calibration.projection(2), middle[0])
    seen = (inside.min(axis=0) + inside.max(axis=0)) / 2
    assert abs(seen[0] - u / 1242 * image.x1) < 0.01
    assert abs(seen[1] - (1 - image.y1 + v / 375 * image.y1)) < 0.03


def test_boxes_behind_the_camera_and_empty_frames_are_drawn_without_fuss() -> None:
    black = {2: np.zeros((375, 1242, 3), np.uint8)}
    frame = SensorFrame("000000", kitti_rig().calibration, black)
    draw_frame(frame, Boxes3D.empty(), {"dsgn": box(0.0, -5.0), "stereo_rcnn": box(1.0, 1.0)})


def test_from_above_forward_is_up_and_right_is_right() -> None:
    nothing = Boxes3D.empty()
    frames = {str(z): (nothing, {"dsgn": box(x, z)}) for x, z in ((-10.0, 40.0), (10.0, 10.0))}
    spots = where(picture_array(draw_frames_from_above(frames)))
    spots = spots[spots[:, 1] < 0.9]  # without the legend
    first, second = spots[spots[:, 0] < 0.5].mean(axis=0), spots[spots[:, 0] > 0.5].mean(axis=0)
    assert first[0] < 0.25
    assert second[0] > 0.75
    assert first[1] < 0.5 < second[1]
