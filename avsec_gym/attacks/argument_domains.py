"""What each number of an attack can be: wide, but nothing that is not finite or no such thing.

What agents choose from is narrower, see the codings of `avsec_gym.envs`.
"""

from __future__ import annotations

import math

Ends = tuple[float, float]

RADII: Ends = (0.01, 1e6)
"""Pixels of a spot of light, or of a patch."""
STRENGTHS: Ends = (0.01, 100_000.0)
"""Grey levels of light; 255 are white."""
PIXELS: Ends = (-1e6, 1e6)
"""Columns and rows, also beyond the image."""
LEVELS: Ends = (1e-6, 255.0)
"""Grey levels by which a pixel is changed."""
STEPS = 100_000
"""Most steps of an attack, or queries of its victim."""
NOISES: Ends = (0.0, 255.0)
"""Grey levels of noise, 0: none."""
COPIES = 10_000
"""Largest number of copies of a frame that a gradient is averaged over."""
MOMENTA: Ends = (0.0, 100.0)
WIDTHS: Ends = (0.001, 1000.0)
"""Metres, of what is made to be seen; heights too."""
DISTANCES: Ends = (0.01, 10_000.0)
"""Metres from a sensor."""
PLACES: Ends = (-10_000.0, 10_000.0)
"""Metres ahead of the car and to its left."""
ANGLES: Ends = (-4 * math.pi, 4 * math.pi)
"""Radians: bearings and headings, two turns either way."""
SHARES: Ends = (0.0, 1.0)
MOST_GHOSTS = 1000
"""The largest number of ghosts at once."""
