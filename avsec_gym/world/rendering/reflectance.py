"""Reflectances as a Velodyne HDL-64E writes them: evened out, graded by laser, often 0."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.world.mesh import Float32s

_NOISE, _MOTTLED = 0.05, 0.15
"""Standard deviation of a reflectance, and of its texture as a share of it."""
_DARK, _DARK_LOST = 0.08, 0.4
"""What reflects less than this in the infrared often gives 0."""
_SHINY, _PAINT_LOST, _SHINY_LOST = 0.05, 0.62, 0.10
"""Car paint (from this share of mirrored light on) sends so many pulses elsewhere that more than
half of what comes back has no grade: 34 to 86 % on 13 real cars.  Other shiny things are dull in
the infrared."""
_RETRO = 0.75
"""Retro-reflectors, which reflect more than this, always have one."""
_FULL, _NONE = 25.0, 70.0
"""Metres from which on reflectances are lost, and where all are."""
_GRAZING, _COUNTS_FARTHER = 0.15, 0.35
"""Ground that is seen more grazingly than this cosine counts as farther away."""


def graded_reflectance(
    reflectance: Float32s,
    cosine: Float32s,
    mirror: Float32s,
    painted: NDArray[np.bool_],
    distance: Float32s,
    gain: Floats,
    floor: float,
    rng: np.random.Generator,
) -> Float32s:
    """Reflectances in hundredths as KITTI's scans give them, fitted to their distribution.

    Args:
        reflectance: Infrared reflectance in [0, 1], shape (n,).
        cosine: Cosine of the angle of incidence, shape (n,).
        mirror: Share of the light that the surface mirrors, shape (n,).
        painted: Whether the surface is a vehicle's, shape (n,).
        distance: Metres, shape (n,).
        gain: Gain of the laser of each pulse, shape (n,).
        floor: Reflectance below which the device gives 0.
        rng: Generator of noise.
    """
    # The device evens dull surfaces out: all but retro-reflectors end in the scale's lower half.
    even = 0.72 * reflectance**0.25 * (0.8 + 0.2 * cosine) + 0.55 * reflectance**6
    weaker = 1.0 - 0.4 * np.clip((distance - 20.0) / 40.0, 0.0, 1.0)
    # Each laser has its gain; what lies below the device's floor is 0: first that of weak lasers.
    texture, noise = rng.standard_normal((2, len(distance)), np.float32)
    shown = even * weaker * gain.astype(np.float32) * (1.0 + _MOTTLED * texture)
    shown += _NOISE * noise - np.float32(floor)
    # Grades are lost far away, at grazing angles, on what is dark, and on what mirrors.
    grazing = np.clip(1.0 - cosine / _GRAZING, 0.0, 1.0)
    farther = distance * (1.0 + _COUNTS_FARTHER * grazing)
    lost = np.clip((farther - _FULL) / (_NONE - _FULL), 0.02, 0.95)
    lost += _DARK_LOST * (reflectance < _DARK)
    shiny = np.clip(mirror / _SHINY, 0.0, 1.0) * (reflectance < _RETRO)
    lost += np.where(painted, np.float32(_PAINT_LOST), np.float32(_SHINY_LOST)) * shiny
    shown[rng.random(len(distance), np.float32) < lost] = 0.0
    return np.asarray(np.round(np.clip(shown, 0.0, 0.99), 2), np.float32)
