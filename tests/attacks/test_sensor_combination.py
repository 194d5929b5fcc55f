"""Several sensors at once: every case, and to each sensor what would happen to it alone."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import OpticalAttack, TamperedFrame
from avsec_gym.attacks.sensor_combination import SensorCombination, attack_cases, thesis_attack
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.registry import make, names
from avsec_gym.rig import kitti_rig
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem

SYSTEM = SensorSystem((LIDAR, 3, 2))
SIZE = (75, 1242, 3)


@pytest.fixture
def frame() -> SensorFrame:
    random = np.random.default_rng(0)
    scan = random.uniform((-20, -20, -1.7, 0), (30, 20, 2, 1), (2000, 4)).astype(np.float32)
    images = {n: random.integers(0, 200, SIZE).astype(np.uint8) for n in (0, 1, 2, 3)}
    return SensorFrame("0", kitti_rig().calibration, images, scan)


def delivered(frame: SensorFrame, sensor: Sensor) -> bytes:
    return (frame.points if sensor == LIDAR else frame.image(int(sensor))).tobytes()


def test_every_case_of_a_system() -> None:
    assert attack_cases(SYSTEM) == (
        *((LIDAR,), (3,), (2,)),
        *((LIDAR, 3), (LIDAR, 2), (3, 2), (LIDAR, 3, 2)),
    )
    six = SensorSystem((LIDAR, 5, 4, 3, 2, 1, 0))
    assert len(set(map(frozenset, attack_cases(six)))) == 2**7 - 1
    assert {len(case) for case in attack_cases(six, most=4)} == {1, 2, 3, 4}


def test_to_each_sensor_happens_what_would_happen_to_it_alone(frame: SensorFrame) -> None:
    alone = {s: thesis_attack((s,)).attack(frame, [8, 1]) for s in SYSTEM.sensors}
    for case in attack_cases(SYSTEM):
        attack = thesis_attack(case)
        tampered = attack.attack(frame, [8, 1])
        assert tampered.attacked == attack.sensors == set(case)
        for sensor in SYSTEM.sensors:
            expected = alone[sensor].frame if sensor in case else frame
            assert delivered(tampered.frame, sensor) == delivered(expected, sensor)
        settings = {key: value for s in case for key, value in alone[s].settings.items()}
        assert tampered.settings == settings
        for camera, mask in tampered.pixels.items():
            np.testing.assert_array_equal(mask, alone[camera].pixels[camera])
        if LIDAR in case:
            np.testing.assert_array_equal(tampered.points, alone[LIDAR].points)


def test_draws_are_independent(frame: SensorFrame) -> None:
    settings = [thesis_attack((0, 3, 2)).attack(frame, seed).settings for seed in range(20)]
    first, second = (
        np.array([each[f"camera_{camera}_radius"] for each in settings]) for camera in (3, 2)
    )
    assert len(np.unique(np.r_[first, second])) == 40
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.5


def test_order_is_of_no_account(frame: SensorFrame) -> None:
    one = thesis_attack((2, 3, LIDAR)).attack(frame, 6).frame
    two = thesis_attack((LIDAR, 3, 2)).attack(frame, 6).frame
    for sensor in SYSTEM.sensors:
        assert delivered(one, sensor) == delivered(two, sensor)


def test_no_attack_changes_nothing(frame: SensorFrame) -> None:
    nothing = thesis_attack(()).attack(frame)
    assert nothing.frame is frame
    assert nothing.attacked == frozenset()


def test_lost_rays_are_handed_on(frame: SensorFrame) -> None:
    both = SensorCombination((Facula(3), LidarSpoofing(rays_lost=True))).attack(frame, 1)
    assert both.lost is not None
    assert both.lost.any()
    assert len(both.frame.points) == len(both.points) == (~both.lost).sum() + both.points.sum()


def test_combinations_combine_with_attacks_of_others(frame: SensorFrame) -> None:
    class Blackout:
        name = "blackout"
        sensors: frozenset[Sensor] = frozenset({2, 3})

        def attack(self, frame: SensorFrame, seed: object = 0) -> TamperedFrame:
            dark = {camera: np.zeros_like(frame.image(camera)) for camera in (2, 3)}
            for camera, image in dark.items():
                frame = frame.with_image(camera, image)
            return TamperedFrame(frame, {c: np.ones(SIZE[:2], bool) for c in dark})

    attack = SensorCombination((Blackout(), LidarSpoofing()))
    assert isinstance(attack, OpticalAttack)
    tampered = attack.attack(frame)
    assert tampered.attacked == {2, 3, LIDAR}
    assert not tampered.frame.image(3).any()


def test_a_sensor_is_attacked_once() -> None:
    with pytest.raises(ConfigurationError, match="once"):
        thesis_attack((2, 3, 2))
    with pytest.raises(ConfigurationError, match="'radar'"):
        thesis_attack(("radar",))


def test_by_name() -> None:
    assert {"facula", "lidar_spoofing", "pasted_scan", "thesis"} <= set(names("optical_attack"))
    assert make("optical_attack", {"name": "facula", "camera": 3}) == Facula(3)
    assert make("optical_attack", "lidar_spoofing") == LidarSpoofing()
    both = make("optical_attack", {"name": "thesis", "sensors": [LIDAR, 3]})
    assert both == SensorCombination((LidarSpoofing(), Facula(3)), "thesis")
