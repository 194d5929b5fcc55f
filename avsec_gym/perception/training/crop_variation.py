"""Variations of images that need no stereo geometry: shifted, mirrored, in other light."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from avsec_gym.perception.training.configuration import Photometric
from avsec_gym.perception.training.drawn_light import GREY, drawn_light

Images = NDArray[np.uint8] | NDArray[np.float32]
"""Shape (..., H, W, 3), grey levels."""


def shifted(images: Sequence[Images], margin: int, down: int, right: int) -> list[Images]:
    """Images without a margin of which each side gives up what the other keeps.

    Args:
        images: The images, each of shape (..., H + 2 margin, W + 2 margin, 3).
        margin: The pixels on every side.
        down: The offset downwards, from 0 to 2 margin; the margin itself takes the middle.
        right: The offset to the right, alike.
    """
    rows = [image.shape[-3] - 2 * margin for image in images]
    columns = [image.shape[-2] - 2 * margin for image in images]
    return [
        image[..., down : down + height, right : right + width, :]
        for image, height, width in zip(images, rows, columns, strict=True)
    ]


def relit_alike(
    images: Sequence[Images], limits: Photometric, randomness: np.random.Generator
) -> list[NDArray[np.float32]]:
    """Images of one scene in other light, which differs a little between them.

    Args:
        images: The images, each of shape (..., H, W, 3).
        limits: The limits of the changes.
        randomness: The generator that draws them.
    """
    light = drawn_light(limits, randomness)
    mean = float(np.mean(images[0]))
    return [
        _relit(image, light.of_view(randomness), mean, light.deviation, randomness)
        for image in images
    ]


def _relit(
    image: Images,
    change: NDArray[np.float64],
    mean: float,
    deviation: float,
    randomness: np.random.Generator,
) -> NDArray[np.float32]:
    brightness, contrast, gamma, saturation = np.exp(change[:4]).astype(np.float32)
    found = 255.0 * (np.asarray(image, np.float32) / 255.0) ** gamma
    found = brightness * (mean + contrast * (found - mean)) * np.exp(change[4:]).astype(np.float32)
    grey = (found @ GREY.astype(np.float32))[..., None]
    found = grey + saturation * (found - grey)
    found += np.float32(deviation) * randomness.standard_normal(found.shape, np.float32)
    return np.asarray(np.clip(found, 0.0, 255.0), np.float32)
