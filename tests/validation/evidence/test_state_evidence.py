"""Evidence that is put together from shared maps is that of the whole attacked frame."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.evidence import gather_evidence
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.state_posterior import state_vectors

SYSTEM = SensorSystem((LIDAR, 2, 1, 0))
ATTACKS = {
    LIDAR: LidarSpoofing(reference=0, distance=6.0, bearing=0.0),
    **{camera: Facula(camera, 50.0, (120.0, 60.0), saturation=0.9) for camera in (0, 1, 2)},
}


def test_every_state_is_that_of_a_frame_attacked_as_a_whole(
    wall_of: Callable[[int], SensorFrame], monkeypatch: pytest.MonkeyPatch
) -> None:
    clean = wall_of(0)
    tampered = {sensor: attack.attack(clean).frame for sensor, attack in ATTACKS.items()}
    states = state_vectors(4)
    expected = []
    for state in states:
        frame = clean
        for sensor, is_attacked in zip(SYSTEM.sensors, state, strict=True):
            frame = ATTACKS[sensor].attack(frame).frame if is_attacked else frame
        errors = DisparityErrors(DisparityMaps(frame, SYSTEM))
        expected.append(gather_evidence(errors))
    matched = []
    find = DisparityMaps._find
    monkeypatch.setattr(
        DisparityMaps, "_find", lambda self, pair: matched.append(pair) or find(self, pair)
    )
    evidence = StateEvidence(clean, tampered, SYSTEM)
    np.testing.assert_array_equal(evidence.evidence(states), expected)
    assert len(matched) == 4 * len(SYSTEM.pairs())
    assert evidence.errors(states[5])[0, 1, 2].error == expected[5][0]
    assert len(matched) == 4 * len(SYSTEM.pairs())
    # Attacked otherwise, the sound sensors are not matched again.
    otherwise = evidence.otherwise({LIDAR: tampered[LIDAR]})
    np.testing.assert_array_equal(otherwise.evidence(states[:2]), expected[:2])
    assert len(matched) == 4 * len(SYSTEM.pairs()) + 2


def test_a_sensor_without_attack_cannot_be_attacked(
    wall_of: Callable[[int], SensorFrame],
) -> None:
    evidence = StateEvidence(wall_of(0), {}, SYSTEM)
    assert evidence.evidence(state_vectors(4)[:1]).shape == (1, 4 + 3 + 3 + 3 + 3)
    with pytest.raises(ConfigurationError, match="no attack on the sensor"):
        evidence.evidence(state_vectors(4)[1:2])


def test_another_scan_leaves_what_cameras_see(
    wall_of: Callable[[int], SensorFrame], monkeypatch: pytest.MonkeyPatch
) -> None:
    clean = wall_of(0)
    tampered = {sensor: attack.attack(clean).frame for sensor, attack in ATTACKS.items()}
    scan = tampered.pop(LIDAR)
    states = state_vectors(4)
    evidence = StateEvidence(clean, tampered, SYSTEM).attacked_too(LIDAR, scan)
    evidence.evidence(states)
    thin, thin_scan = clean.points[::2], scan.with_points(scan.points[::2])
    matched: list[tuple[int, int]] = []
    find = DisparityMaps._find
    monkeypatch.setattr(
        DisparityMaps, "_find", lambda self, pair: matched.append(pair) or find(self, pair)
    )
    found = evidence.with_scan(thin).attacked_too(LIDAR, thin_scan).evidence(states)
    # Maps of the scan in each camera that is a reference, of four states each, and no other.
    assert sorted(matched) == [(0, 2)] * 4 + [(0, 3)] * 4
    fresh = StateEvidence(clean.with_points(thin), {**tampered, LIDAR: thin_scan}, SYSTEM)
    np.testing.assert_array_equal(found, fresh.evidence(states))
    with pytest.raises(ConfigurationError, match="given already"):
        evidence.attacked_too(LIDAR, scan)
    with pytest.raises(ConfigurationError, match="no attack on the sensor 'lidar'"):
        evidence.with_scan(thin).evidence(states[1:2])
