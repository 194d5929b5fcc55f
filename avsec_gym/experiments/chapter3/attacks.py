"""The optical attacks of chapter 3: those of the thesis, others to fit on, and others to judge.

What is fitted has seen neither the seeds nor the kinds of attack that are judged.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.attacks_to_fit_on import attack_to_fit_on, attacked_in_turn
from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import OpticalAttack, TamperedFrame
from avsec_gym.attacks.seed_numbers import seed_numbers
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem

SMALLER, OTHER = "smaller", "other"
"""Kinds of attack beyond the thesis' that are judged, too."""
BEYOND = {
    SMALLER: (LidarSpoofing(width=1.0), Facula(radius=(60.0, 120.0))),
    OTHER: (LidarSpoofing(rays_lost=True), Facula(strength=128.0)),
}
"""The bounds by kind: on the LiDAR, and on a camera."""

_STREAM = {FITTED: 1, JUDGED: 2, SMALLER: 3, OTHER: 4}


def attack_of(
    sensor: Sensor, reference: int, kind: str, random: np.random.Generator
) -> OpticalAttack:
    """The attack on one sensor; what it leaves open is drawn when it attacks.

    Args:
        sensor: A camera's number or `LIDAR`.
        reference: The camera in whose view bogus returns are.
        kind: `JUDGED`, the thesis'; `FITTED`; or one of `BEYOND`.
        random: The generator that draws which of the attacks to fit on.
    """
    if kind == FITTED:
        return attack_to_fit_on(sensor, random, reference)
    spoofing, facula = BEYOND.get(kind, (LidarSpoofing(), Facula()))
    if sensor == LIDAR:
        return replace(spoofing, reference=reference)
    return replace(facula, camera=int(sensor))


def tampered_frames(
    frame: SensorFrame, system: SensorSystem, kind: str, seed: Seed
) -> dict[Sensor, TamperedFrame]:
    """The frame with one sensor attacked at a time, each by draws of its own.

    Args:
        frame: The frame without an attack.
        system: The sensors of the frame.
        kind: The kind of attack, see `attack_of`.
        seed: Seed of the attacks on this frame.
    """
    own = [*seed_numbers(seed), _STREAM[kind]]
    return attacked_in_turn(
        frame, system, lambda sensor, random: attack_of(sensor, system.reference, kind, random), own
    )
