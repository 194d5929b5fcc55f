"""How uneven the ground is for a laser: swells of roads that no camera sees, and blades of grass.

The meshes of a scene stay as they are: a centimetre of height moves a pulse's end along the pulse,
the farther the more grazing it is.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from avsec_gym.kernels import kernel
from avsec_gym.world.mesh import Float32s
from avsec_gym.world.section import Surface

_CELL, _CELLS = 0.5, 256
"""Spacing of the heights (metres) and their number along each side; they repeat after 128 m."""
_LENGTHS = (2.0, 16.0)
"""Shortest and longest swell, metres."""
_HEIGHT = 0.011
"""Standard deviation of a road's height, metres."""
_ROUGHER = 3.0
"""Land beside the road has so many times the road's swells."""
_BLADES, _HIGHEST = 0.006, 0.06
"""Mean and greatest height of the grass in which a pulse ends, metres."""
_LONGEST = 0.5
"""Metres that a pulse's end is moved at most."""
_FIRST, _LAST, _GRASS = int(Surface.ROAD), int(Surface.TERRAIN), int(Surface.VERGE)


@lru_cache(maxsize=4)
def draw_relief(seed: int) -> Float32s:
    """The heights of a place's swells, metres, on a grid of half a metre, shape (256, 256)."""
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence((seed, 2))))
    # White noise, of which only swells of the right lengths are kept, long ones higher.
    number = np.fft.fftfreq(_CELLS, _CELL)
    per_metre = np.hypot(number[:, None], number[None, :])
    kept = (per_metre > 1.0 / _LENGTHS[1]) & (per_metre < 1.0 / _LENGTHS[0])
    weight = np.where(kept, 1.0 / np.maximum(per_metre, 1e-9) ** 2, 0.0)
    heights = np.fft.ifft2(np.fft.fft2(rng.standard_normal((_CELLS, _CELLS))) * weight).real
    result = (heights * (_HEIGHT / heights.std())).astype(np.float32)
    result.flags.writeable = False
    return result


def raise_ground(
    distance: Float32s,
    origins: Float32s,
    directions: Float32s,
    cosine: Float32s,
    surface: NDArray[np.uint8],
    relief: Float32s,
    chance: Float32s,
) -> None:
    """Move the ends of pulses on the ground to where uneven ground would stop them; in place.

    Args:
        distance: Distances of the ends, metres, infinite for none, shape (n,).
        origins: Origins of the pulses, metres, shape (n, 3).
        directions: Unit vectors along the pulses, shape (n, 3).
        cosine: Cosine of the angle of incidence, shape (n,).
        surface: `Surface` of the ends, shape (n,).
        relief: Result of `draw_relief`.
        chance: Uniform in [0, 1), for the blades of grass, shape (n,).
    """
    _raise(distance, origins, directions, cosine, surface, relief, chance)


@kernel()
def _raise(  # type: ignore[no-untyped-def]
    distance, origins, directions, cosine, surface, relief, chance
):
    size = len(relief)
    for i in range(len(distance)):
        kind = surface[i]
        if kind < _FIRST or kind > _LAST or not np.isfinite(distance[i]):
            continue
        # The height of the swells there, between the four cells around.
        east = (origins[i, 0] + distance[i] * directions[i, 0]) / np.float32(_CELL)
        north = (origins[i, 1] + distance[i] * directions[i, 1]) / np.float32(_CELL)
        column, row = int(np.floor(east)), int(np.floor(north))
        a, b = east - column, north - row
        # Invariant: a remainder by the size is an index, for negative cells too.
        left, right = column % size, (column + 1) % size
        low, high = row % size, (row + 1) % size
        height = (1 - b) * ((1 - a) * relief[left, low] + a * relief[right, low]) + b * (
            (1 - a) * relief[left, high] + a * relief[right, high]
        )
        if kind >= _GRASS:
            # Most pulses end low in the grass: the height is exponential.
            blade = min(-_BLADES * np.log(1.0 - chance[i]), _HIGHEST)
            height = _ROUGHER * height + blade
        along = height / max(cosine[i], np.float32(0.02))
        distance[i] -= min(max(along, -_LONGEST), min(_LONGEST, 0.5 * distance[i]))
