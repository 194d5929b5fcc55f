"""The optical attacks of chapter 3: those of the thesis, and others that likelihoods are fitted on.

What is fitted has seen neither the seeds nor the sizes of what is judged.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.facula import THESIS_RADII, Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import OpticalAttack, TamperedFrame
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem

OTHER_RADII = ((120.0, THESIS_RADII[0]), (THESIS_RADII[1], 450.0))
"""Of faculae to fit on: smaller and larger ones than the thesis', pixels."""
OTHER_DISTANCES = ((4.5, 6.0), (10.0, 14.0))
"""Of bogus returns to fit on: nearer and farther than the thesis', metres."""
OTHER_WIDTHS = (2.0, 3.0)
"""And narrower or wider than 2.5 m."""

_STREAM = {FITTED: 1, JUDGED: 2}


def attack_of(
    sensor: Sensor, reference: int, part: str, random: np.random.Generator
) -> OpticalAttack:
    """On one sensor; what it leaves open is drawn when it attacks.

    Args:
        sensor: A camera's number or `LIDAR`.
        reference: The camera in whose view bogus returns are.
        part: `FITTED` or `JUDGED`.
        random: Draws which of the sizes to fit on.
    """
    larger = int(random.integers(2))
    if part == JUDGED:
        return LidarSpoofing(reference=reference) if sensor == LIDAR else Facula(int(sensor))
    if sensor == LIDAR:
        width, distance = OTHER_WIDTHS[int(random.integers(2))], OTHER_DISTANCES[larger]
        return LidarSpoofing(width=width, distance=distance, reference=reference)
    return Facula(int(sensor), OTHER_RADII[larger])


def tampered_frames(
    frame: SensorFrame, system: SensorSystem, part: str, seed: Seed
) -> dict[Sensor, TamperedFrame]:
    """The moment with one sensor attacked at a time, each by draws of its own.

    Args:
        frame: As it is.
        system: Its sensors.
        part: `FITTED` or `JUDGED`.
        seed: Of the moment.
    """
    result = {}
    for position, sensor in enumerate(system.sensors):
        own = [*([seed] if isinstance(seed, int) else seed), _STREAM[part], position + 1]
        attack = attack_of(sensor, system.reference, part, np.random.default_rng(own))
        result[sensor] = attack.attack(frame, own)
    return result
