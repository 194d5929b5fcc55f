"""Noise that repeats: the raw material of the textures."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.world.textures.texture import Picture

Noise = NDArray[np.float32]
"""Shape (h, w), mean 0, standard deviation about 1; repeats in both directions."""


def white_noise(rng: np.random.Generator, height: int, width: int, blur: float = 0.0) -> Noise:
    """Independent pixels, or blurred by a Gaussian of `blur` pixels."""
    noise = rng.standard_normal((height, width), np.float32)
    if blur <= 0:
        return noise
    margin = int(3 * blur) + 1
    wide = cv2.copyMakeBorder(noise, margin, margin, margin, margin, cv2.BORDER_WRAP)
    smooth = cv2.GaussianBlur(wide, (0, 0), blur)[margin:-margin, margin:-margin]
    return np.asarray((smooth - smooth.mean()) / (smooth.std() + 1e-6), np.float32)


def fractal_noise(
    rng: np.random.Generator,
    height: int,
    width: int,
    *,
    cells: float = 4,
    octaves: int = 6,
    persistence: float = 0.5,
) -> Noise:
    """Clouds upon clouds: octaves of smooth noise, each twice as fine as the last.

    Args:
        rng: The source of chance.
        height: Height of the picture, pixels.
        width: Width of the picture, pixels.
        cells: Number of cells of the coarsest octave along the longer side.
        octaves: Largest number of octaves; those finer than a pixel are left out.
        persistence: Amplitude of an octave relative to the last.
    """
    total = np.zeros((height, width), np.float32)
    scale = max(height, width)
    amplitude = 1.0
    for octave in range(octaves):
        count = cells * 2**octave
        if count > scale:
            break
        rows, columns = max(1, round(count * height / scale)), max(1, round(count * width / scale))
        lattice = rng.standard_normal((rows, columns), np.float32)
        lattice = np.pad(lattice, 3, mode="wrap")
        # Sampled at its cells' centres, with three cells of margin, cut off again below.
        y = (np.arange(height, dtype=np.float32) + 0.5) * rows / height + 2.5
        x = (np.arange(width, dtype=np.float32) + 0.5) * columns / width + 2.5
        total += amplitude * cv2.remap(
            lattice,
            np.broadcast_to(x, (height, width)).copy(),
            np.broadcast_to(y[:, None], (height, width)).copy(),
            cv2.INTER_CUBIC,
        )
        amplitude *= persistence
    total -= total.mean()
    return np.asarray(total / (total.std() + 1e-6), np.float32)


def coloured(
    colour: ArrayLike, noise: NDArray[np.floating], contrast: float
) -> NDArray[np.float32]:
    """A colour (0..255 each) that varies by noise: ``colour * (1 + contrast * noise)``."""
    base = np.asarray(colour, np.float32)
    return np.asarray(base * (1.0 + contrast * noise[..., None]), np.float32)


def picture(values: ArrayLike) -> Picture:
    """Rounded and clipped to 0..255."""
    return np.clip(np.asarray(values, np.float32) + 0.5, 0, 255).astype(np.uint8)
