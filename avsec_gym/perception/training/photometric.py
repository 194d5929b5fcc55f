"""Other light, other cameras: brightness, contrast, gamma, colour, noise, and unequal views."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avsec_gym.perception.training.configuration import Photometric
from avsec_gym.perception.training.drawn_light import GREY, drawn_light
from avsec_gym.perception.training.sample import Map, Pixels, StereoSample

_NOISE_VALUES = 1 << 20


def relit(
    sample: StereoSample, limits: Photometric, randomness: np.random.Generator
) -> StereoSample:
    """A sample with other light; images stay in whole grey levels, as cameras deliver them.

    Args:
        sample: Images are uint8.
        limits: The limits of the changes.
        randomness: The generator that draws them.
    """
    light = drawn_light(limits, randomness)
    mean = float(sample.left[::8, ::8].mean())
    # Where nothing is to be grey, nothing is drawn: samples stay as they were.
    is_grey = limits.grey > 0 and randomness.random() < limits.grey
    left, right = (
        _view(image, light.of_view(randomness), mean, light.deviation, randomness)
        for image in (sample.left, sample.right)
    )
    if is_grey:
        left, right = (_without_colours(image) for image in (left, right))
    return replace(sample, left=left, right=right)


def _without_colours(image: Pixels) -> Pixels:
    return np.repeat(np.rint(image.mean(axis=2, keepdims=True)).astype(np.uint8), 3, axis=2)


def _view(
    image: Pixels,
    change: NDArray[np.float64],
    mean: float,
    deviation: float,
    randomness: np.random.Generator,
) -> Pixels:
    import cv2

    brightness, contrast, gamma, saturation = np.exp(change[:4])
    levels = 255.0 * (np.arange(256) / 255.0) ** gamma
    levels = brightness * (mean + contrast * (levels - mean))
    table = levels[:, None] * np.exp(change[None, 4:])
    found = cv2.LUT(np.asarray(image, np.uint8), table[None].astype(np.float32))
    mixture = saturation * np.eye(3) + (1 - saturation) * np.tile(GREY, (3, 1))
    result: Map = np.asarray(cv2.transform(found, mixture.astype(np.float32)))
    if deviation > 0:
        start = int(randomness.integers(_NOISE_VALUES))
        noise = _noise(result.size)[start : start + result.size]
        result += np.float32(deviation) * noise.reshape(result.shape)
    return np.rint(np.clip(result, 0.0, 255.0, out=result), out=result).astype(np.uint8)


@functools.cache
def _noise(values: int) -> NDArray[np.float32]:
    """Normal noise, of which each view takes a piece: drawing it anew would take longest of all."""
    return np.random.default_rng(0).standard_normal(values + _NOISE_VALUES, np.float32)
