"""Optical attacks that likelihoods are fitted on: of other sizes and kinds than the thesis'.

What is fitted is to be judged by attacks that it has not seen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.facula import THESIS_RADII, Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import OpticalAttack, TamperedFrame
from avsec_gym.attacks.seed_numbers import seed_numbers
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem

_T = TypeVar("_T")

FITTED_RADII = ((120.0, THESIS_RADII[0]), (THESIS_RADII[1], 450.0))
"""Radii of faculae to fit on: smaller and larger ones than the thesis', pixels."""
FITTED_COLOURS = ((1.0, 0.2, 0.1), (0.1, 1.0, 0.2), (0.2, 0.3, 1.0))
"""Colours of lasers to fit on: red, green, blue. The thesis' faculae are white."""
FITTED_SATURATIONS = (0.3, 0.6)
"""Saturations of white light that overflows the sensor; the thesis' is Gaussian throughout."""
FITTED_DISTANCES = ((4.5, 6.0), (10.0, 14.0))
"""Distances of bogus returns to fit on: nearer and farther than the thesis', metres."""
FITTED_WIDTHS = (2.0, 3.0)
"""Narrower or wider than 2.5 m."""
FITTED_HEIGHTS = (1.0, 2.0)
"""Lower or higher than 1.5 m."""


def attack_to_fit_on(
    sensor: Sensor, random: np.random.Generator, reference: int
) -> LidarSpoofing | Facula:
    """One of the attacks above; what it leaves open is drawn when it attacks.

    Args:
        sensor: A camera's number or `LIDAR`.
        random: Generator that draws the attack.
        reference: The camera in whose view bogus returns are.
    """
    if sensor == LIDAR:
        return LidarSpoofing(
            width=_one_of(FITTED_WIDTHS, random),
            height=_one_of(FITTED_HEIGHTS, random),
            distance=_one_of(FITTED_DISTANCES, random),
            reference=reference,
        )
    facula = Facula(int(sensor), _one_of(FITTED_RADII, random))
    if random.integers(2):
        return replace(facula, colour=_one_of(FITTED_COLOURS, random))
    return replace(facula, saturation=_one_of(FITTED_SATURATIONS, random))


def attacked_in_turn(
    frame: SensorFrame,
    system: SensorSystem,
    attack_of: Callable[[Sensor, np.random.Generator], OpticalAttack],
    seed: Seed,
) -> dict[Sensor, TamperedFrame]:
    """The frame with one sensor attacked at a time, each by draws of its own.

    Args:
        frame: The clean frame.
        system: Sensors of the frame.
        attack_of: Function from a sensor and a generator to the attack on the sensor.
        seed: Seed of the frame.
    """
    result = {}
    for position, sensor in enumerate(system.sensors):
        own = [*seed_numbers(seed), position + 1]
        # Two streams: were they one, the same draw would choose an attack and its place.
        which, where = [*own, 1], [*own, 2]
        result[sensor] = attack_of(sensor, np.random.default_rng(which)).attack(frame, where)
    return result


def _one_of(choices: tuple[_T, ...], random: np.random.Generator) -> _T:
    return choices[int(random.integers(len(choices)))]
