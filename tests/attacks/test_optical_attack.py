"""Optical attacks on sensors that are not there."""

from __future__ import annotations

import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import check_attacked, check_there
from avsec_gym.errors import ConfigurationError
from avsec_gym.sensor_system import LIDAR


def test_attacks_on_sensors_that_are_there_pass() -> None:
    check_attacked(Facula(2), (2, 3), "the scenes")
    check_attacked(LidarSpoofing(), (LIDAR, 2), "the scenes")
    # Another kind of attack, and none.
    check_attacked(object(), (), "the scenes")
    check_attacked(None, (), "the scenes")


@pytest.mark.parametrize(
    ("attack", "there", "text"),
    [
        (Facula(1), (3, 2), "on camera 1, but the scenes have camera 2, camera 3: attack one"),
        (LidarSpoofing(), (2,), "on the LiDAR, but the scenes have camera 2: attack one"),
        (Facula(2), (), "the scenes have no sensor"),
    ],
)
def test_others_are_refused_with_what_there_is(
    attack: object, there: tuple[int, ...], text: str
) -> None:
    with pytest.raises(ConfigurationError, match=text):
        check_attacked(attack, there, "the scenes")


def test_all_that_lack_are_named() -> None:
    with pytest.raises(ConfigurationError, match="one on camera 0 and camera 1, but the sets have"):
        check_there("mine", frozenset({1, 0, 2}), (2,), "the sets")
