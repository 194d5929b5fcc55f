"""Anchors seen from above, and boxes as corners."""

from __future__ import annotations

import numpy as np
import torch
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import wrap_angle
from avsec_gym.perception.detectors.dsgn.anchors import (
    anchor_footprints,
    boxes_of_corners,
    corners_of_boxes,
)
from avsec_gym.perception.detectors.dsgn.box_field import BoxField
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration


def _boxes(location: list[float], size: list[float], yaw: float) -> Boxes3D:
    return Boxes3D(
        np.array([location]), np.array([size]), np.array([yaw]), np.ones(1), np.array(["Car"])
    )


def test_corners_of_a_box_along_x_are_in_the_order_of_the_paper_s_code() -> None:
    corners = corners_of_boxes(_boxes([1.0, 2.0, 10.0], [1.5, 1.6, 4.0], 0.0))[0]
    front, back, left, right = 3.0, -1.0, 10.8, 9.2
    bottom = [(front, left), (front, right), (back, right), (back, left)]
    np.testing.assert_allclose(corners[:4], [(x, 2.0, z) for x, z in bottom])
    np.testing.assert_allclose(corners[4:], [(x, 0.5, z) for x, z in bottom])


@given(
    st.tuples(*[st.floats(-40, 40)] * 3),
    st.tuples(*[st.floats(0.3, 12)] * 3),
    st.floats(-np.pi, np.pi),
)
def test_corners_and_back(location: tuple[float, ...], size: tuple[float, ...], yaw: float) -> None:
    corners = corners_of_boxes(_boxes(list(location), list(size), yaw))
    found_location, found_size, found_yaw = boxes_of_corners(corners)
    np.testing.assert_allclose(found_location[0], location, atol=1e-9)
    np.testing.assert_allclose(found_size[0], size, atol=1e-9)
    assert abs(wrap_angle(found_yaw[0] - yaw)) < 1e-9


def test_a_box_whose_corners_are_shaken_stays_where_it_was() -> None:
    corners = corners_of_boxes(_boxes([3.0, 1.6, 20.0], [1.5, 1.6, 4.0], 1.0))
    shaken = corners + np.random.default_rng(0).normal(0, 0.02, corners.shape)
    location, size, yaw = boxes_of_corners(shaken)
    np.testing.assert_allclose(location, [[3.0, 1.6, 20.0]], atol=0.05)
    np.testing.assert_allclose(size, [[1.5, 1.6, 4.0]], atol=0.05)
    np.testing.assert_allclose(yaw, [1.0], atol=0.05)


def test_footprints_are_those_of_the_boxes_that_an_untrained_network_emits(
    tiny: DsgnConfiguration,
) -> None:
    zeros = torch.zeros(1, 1, 6 + tiny.angles, 1, 1)
    emitted = BoxField(zeros, tiny).everywhere()[0, :, 0, :4, :, 0, 0]
    footprints = anchor_footprints(tiny)[0]
    np.testing.assert_allclose(footprints, emitted[..., [0, 2]], atol=1e-5)
    car = tiny.anchors[0]
    np.testing.assert_allclose(footprints[0, 0], [car.length / 2, car.width / 2])
