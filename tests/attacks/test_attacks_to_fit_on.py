"""Attacks that likelihoods are fitted on: other ones than those that judge them."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.attacks.attacks_to_fit_on import (
    FITTED_COLOURS,
    FITTED_DISTANCES,
    FITTED_HEIGHTS,
    FITTED_RADII,
    FITTED_SATURATIONS,
    FITTED_WIDTHS,
    attack_to_fit_on,
    attacked_in_turn,
)
from avsec_gym.attacks.facula import THESIS_RADII, Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig
from avsec_gym.sensor_system import LIDAR, SensorSystem


def test_a_lidar_is_spoofed_by_every_combination_and_no_other() -> None:
    random = np.random.default_rng(0)
    seen = set()
    for _ in range(200):
        attack = attack_to_fit_on(LIDAR, random, 3)
        assert isinstance(attack, LidarSpoofing)
        assert attack.reference == 3
        seen.add((attack.width, attack.height, attack.distance))
    every = {(w, h, d) for w in FITTED_WIDTHS for h in FITTED_HEIGHTS for d in FITTED_DISTANCES}
    assert seen == every


def test_a_camera_gets_light_of_other_sizes_coloured_or_overflowing() -> None:
    random = np.random.default_rng(0)
    seen = set()
    for _ in range(300):
        attack = attack_to_fit_on(2, random, 3)
        assert isinstance(attack, Facula)
        assert attack.camera == 2
        white = attack.colour == (1.0, 1.0, 1.0)
        assert white == (attack.saturation > 0)
        seen.add((attack.radius, attack.saturation if white else attack.colour))
    kinds = (*FITTED_COLOURS, *FITTED_SATURATIONS)
    assert seen == {(radius, kind) for radius in FITTED_RADII for kind in kinds}
    # Beside what judges, not within it.
    assert all(high <= THESIS_RADII[0] or low >= THESIS_RADII[1] for low, high in FITTED_RADII)


@pytest.mark.parametrize("seed", [4, np.int64(4), (4, 9)])
def test_one_sensor_at_a_time_each_by_draws_of_its_own(seed: int | tuple[int, ...]) -> None:
    rng = np.random.default_rng(1)
    images = {camera: rng.integers(0, 200, (60, 199, 3), np.uint8) for camera in (2, 3)}
    frame = SensorFrame("0", kitti_rig().calibration, images, np.zeros((0, 4), np.float32))
    asked = []

    def attack_of(sensor, random):
        asked.append((sensor, int(random.integers(2**40))))
        return Facula(2 if sensor == LIDAR else sensor)

    system = SensorSystem((LIDAR, 3, 2))
    found = attacked_in_turn(frame, system, attack_of, seed)
    assert list(found) == list(system.sensors)
    assert [sensor for sensor, _ in asked] == list(system.sensors)
    assert len({draw for _, draw in asked}) == 3
    # Whichever attack it is, its place is drawn by another stream, the same each time.
    own = [4, *((9,) if isinstance(seed, tuple) else ())]
    for position, (sensor, tampered) in enumerate(found.items(), start=1):
        camera = 2 if sensor == LIDAR else sensor
        again = Facula(camera).attack(frame, [*own, position, 2]).settings
        assert tampered.settings == again
        assert dict(asked)[sensor] == int(
            np.random.default_rng([*own, position, 1]).integers(2**40)
        )
