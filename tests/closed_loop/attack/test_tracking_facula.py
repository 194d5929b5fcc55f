"""The spot stays on its object in the image while car and object move."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.closed_loop.attack.tracking_facula import TrackingFacula
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig, resized_rig
from tests.closed_loop.attack.surroundings import around

RIG = resized_rig(kitti_rig(), 414)
ON = np.array([1.0, -1.0, 0.25, 0.0, -0.8])
"""Into the left camera, from what is nearest to 30 m straight ahead: actor 7."""


def dark() -> SensorFrame:
    black = np.zeros((125, 414, 3), np.uint8)
    return SensorFrame("000000", RIG.calibration, {2: black, 3: black})


def spot(attack: TrackingFacula, pose: tuple[float, float, float], camera: int = 2) -> float:
    """Bearing of the brightest column, radians to the left."""
    frame = attack.tampered(dark(), around(pose))
    column = frame.image(camera)[..., 0].astype(float).sum(axis=0).argmax()
    projection = RIG.calibration.projection(camera)
    return float(-np.arctan((column - projection[0, 2]) / projection[0, 0]))


def test_the_spot_follows_the_object() -> None:
    attack = TrackingFacula()
    attack.act(ON, around((0.0, 0.0, 0.0)))
    for pose in ((0.0, 0.0, 0.0), (10.0, 2.0, 0.1), (20.0, -1.0, -0.2)):
        bearing = np.arctan2(0.0 - pose[1], 30.0 - pose[0]) - pose[2]
        assert spot(attack, pose) == pytest.approx(bearing, abs=0.03)
        attack.act(ON * [1, 1, -1, 1, 1], around(pose))  # Another place: it stays on its object.


def test_only_the_chosen_camera_is_blinded_and_off_is_dark() -> None:
    attack = TrackingFacula()
    seen = around((0.0, 0.0, 0.0))
    assert attack.act(ON * [1, -1, 1, 1, 1], seen) == pytest.approx((71.25 / 375.0) ** 2)
    assert attack.facts["camera"] == 3
    frame = attack.tampered(dark(), seen)
    assert frame.image(2).max() == 0
    assert frame.image(3).max() > 200
    assert attack.act(-np.ones(5), seen) == 0.0
    assert attack.tampered(dark(), seen).image(3).max() == 0


def test_an_object_behind_the_car_shines_into_no_camera() -> None:
    attack = TrackingFacula()
    attack.act(ON, around((0.0, 0.0, 0.0)))
    assert attack.tampered(dark(), around((50.0, 0.0, 0.0))).image(2).max() == 0
