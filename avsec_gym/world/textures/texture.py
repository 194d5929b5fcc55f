"""A texture: a picture that repeats over a surface, made from a seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
"""Shape (h, w, 3), red, green, blue as a screen shows them (sRGB)."""


@dataclass(frozen=True)
class Texture:
    """How a family of textures is made.

    Args:
        size: Width and height of one repeat, metres.
        variants: Number of variants: ``brick/0`` to ``brick/5`` for 6.
        make: Function that draws variant i with a generator that belongs to it; the picture's left
            edge continues at its right one, its lower at its upper one, unless the surface shows it
            only once.
    """

    size: tuple[float, float]
    variants: int
    make: Callable[[int, np.random.Generator], Picture]
