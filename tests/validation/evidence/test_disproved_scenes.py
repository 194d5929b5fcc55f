"""Scan points whom the images of two cameras disprove, in a scene."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors, densest_share
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps

SYSTEM = SensorSystem((LIDAR, 2, 1, 0))


def test_a_bogus_return_is_disproved_and_light_is_none(
    wall_of: Callable[[int], SensorFrame],
) -> None:
    wall = wall_of(0)
    bogus = LidarSpoofing(reference=0, distance=6.0, bearing=0.0).attack(wall).frame
    lit = Facula(1, 300.0, (120.0, 60.0), saturation=0.9).attack(wall).frame
    clean, spoofed, dazzled = (
        DisparityErrors(DisparityMaps(frame, SYSTEM))[0, 2, 3] for frame in (wall, bogus, lit)
    )
    assert clean.densest < 0.002
    assert spoofed.densest > 0.02
    # E cannot tell which of the two is wrong, the images can.
    assert dazzled.error + dazzled.hole_share > 0.05
    assert dazzled.densest < 0.25 * spoofed.densest
    assert densest_share(np.zeros((10, 10), bool)) == 0.0


def test_a_bogus_return_behind_a_wall_is_disproved(wall_of: Callable[[int], SensorFrame]) -> None:
    """Whose points would be the nearest in few pixels: the wall's own stand before them."""
    wall = wall_of(0)
    behind = LidarSpoofing(reference=0, distance=20.0, bearing=0.0).attack(wall).frame
    clean, spoofed = (
        DisparityErrors(DisparityMaps(frame, SYSTEM))[0, 2, 3].densest for frame in (wall, behind)
    )
    assert spoofed > 5 * max(clean, 0.002)
