"""Where named sensors are damaged, on a smooth wall that three cameras and a scan see alike."""

from __future__ import annotations

import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.repair.damage import located_damage
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation

SYSTEM = SensorSystem((LIDAR, 2, 1, 0))


def said_of(
    frame: SensorFrame, attacked: set[Sensor], doubtful: frozenset[Sensor] = frozenset()
) -> Validation:
    statuses: dict[Sensor, SensorStatus] = dict.fromkeys(SYSTEM.sensors, SensorStatus.SOUND)
    statuses |= dict.fromkeys(attacked, SensorStatus.ATTACKED)
    statuses |= dict.fromkeys(doubtful, SensorStatus.CANNOT_TELL)
    return Validation(bool(attacked), statuses, DisparityErrors(DisparityMaps(frame, SYSTEM)))


def test_light_is_where_it_shines(soft_wall: SensorFrame) -> None:
    assert located_damage(said_of(soft_wall, set())) == {}
    tampered = Facula(1, 180.0, (130.0, 60.0), saturation=0.3).attack(soft_wall)
    damage = located_damage(said_of(tampered.frame, {1}))
    assert list(damage) == [1]
    found, true = damage[1].pixels, tampered.pixels[1]
    assert found is not None
    assert (found & true).sum() > 0.85 * (found | true).sum()
    assert damage[1].row == {"share_of_pixels": round(found.mean(), 6)}


def test_bogus_points_are_counted(soft_wall: SensorFrame) -> None:
    tampered = LidarSpoofing(width=1.5, distance=6.0, bearing=0.05, reference=0).attack(soft_wall)
    row = located_damage(said_of(tampered.frame, {LIDAR}))[LIDAR].row
    assert tampered.points is not None
    assert row["points"] == pytest.approx(tampered.points.sum(), rel=0.1)


def test_who_is_not_sound_is_not_asked(soft_wall: SensorFrame) -> None:
    """The LiDAR and one camera tell of the other two, but cannot tell of the LiDAR."""
    damage = located_damage(said_of(soft_wall, {LIDAR, 1, 2}, frozenset({2})))
    assert damage[LIDAR].row == {"unknown": "a LiDAR is checked by two trusted cameras or more"}
    assert "trusted are: 0" in damage[1].row["unknown"]
    assert set(damage) == {LIDAR, 1}
    assert located_damage(said_of(soft_wall, {1}, frozenset({2})))[1].pixels is not None
