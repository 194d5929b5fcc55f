"""The lasers of one Velodyne HDL-64E: where they sit, how they tilt, how strong they are."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from avsec_gym.geometry import Floats

NOMINAL = 64
"""Seed of the device that stands for all others: its lasers are weak where others' are, too."""

_TILT, _TILT_LOWER = np.radians(0.03), np.radians(0.045)
"""Standard deviations of the mounting angles about the nominal ones, upper and lower block."""
_TILT_ERROR = np.radians(0.045)
"""What a calibration leaves of a laser's tilt: its rings lie a little too high or too low..."""
_RANGE_ERROR = 0.012
"""... and what it leaves of a laser's range, metres."""
_GAIN, _WEAK_GAIN, _WEAK_SHARE = 0.08, (0.45, 0.75), 0.2
_FLOOR, _FLOOR_SPREAD = 0.15, 0.4
"""Median and spread (of the logarithm) of the reflectance that a device takes for nothing."""


class Lasers(NamedTuple):
    """The lasers of a device, from the top, shape (64,) each unless stated."""

    elevation: Floats
    """Radians above the horizontal."""
    azimuth: Floats
    """Radians by which a laser fires ahead of its head's direction, within one step of it."""
    height: Floats
    """Where a laser's ray begins above the origin of the velodyne frame, metres."""
    elevation_error: Floats
    """True less calibrated elevation, radians."""
    range_error: Floats
    """Measured less true range, metres."""
    gain: Floats
    """Factor of the reflectances; one laser in five is weak."""
    floor: float
    """Reflectance below which this device gives 0."""


@lru_cache(maxsize=64)
def draw_lasers(seed: int, azimuth_step: float) -> Lasers:
    """The lasers of the device with that seed, around a common nominal device.

    Nominal angles, heights and spreads are those that KITTI's scans show: in them, each ring is
    a cone with its tip 0.20 to 0.21 m (32 upper lasers) or 0.12 to 0.13 m (32 lower ones) above
    the origin, true to a tenth of a millimetre.

    Args:
        seed: Seed of the device: one seed, one device.
        azimuth_step: Step of the head's angle encoder, radians.
    """
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence((seed, 1))))
    upper, lower = np.linspace(1.94, -8.71, 32), np.linspace(-9.03, -25.0, 32)
    tilts = np.repeat([_TILT, _TILT_LOWER], 32) * rng.standard_normal(64)
    # Which lasers are weak belongs to the type: most devices share it.
    common = np.random.Generator(np.random.PCG64(NOMINAL))
    weak = common.random(64) < _WEAK_SHARE
    weak ^= rng.random(64) < 0.5 * _WEAK_SHARE * np.where(weak, 1.0, 0.25)
    gain = np.where(weak, rng.uniform(*_WEAK_GAIN, 64), 1.0) + _GAIN * rng.standard_normal(64)
    return Lasers(
        elevation=np.radians(np.concatenate([upper, lower])) + tilts,
        azimuth=azimuth_step * rng.uniform(0.02, 0.98, 64),
        height=np.concatenate([np.linspace(0.21, 0.20, 32), np.linspace(0.13, 0.12, 32)]),
        elevation_error=_TILT_ERROR * rng.standard_normal(64),
        range_error=_RANGE_ERROR * rng.standard_normal(64),
        gain=np.clip(gain, 0.3, 1.4),
        floor=float(_FLOOR * np.exp(_FLOOR_SPREAD * rng.standard_normal())),
    )
