"""Defences of images, against other libraries and against what their names promise."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind, make, names

_RANDOM = np.random.default_rng(0)


def _noise(low: int = 0) -> np.ndarray:
    return np.random.default_rng(5).integers(low, 256, (37, 53, 3), np.uint8)


def _street() -> np.ndarray:
    """Smooth, and of a colour that shows whether red and blue were exchanged."""
    rows, columns = np.mgrid[0:64, 0:96]
    return np.stack([rows * 3, columns * 2, np.full_like(rows, 40)], axis=2).astype(np.uint8)


@pytest.mark.parametrize("name", names(Kind.DEFENCE))
def test_what_is_drawn_follows_from_the_generator_and_the_image_stays(name: str) -> None:
    defence, image = make(Kind.DEFENCE, name), _street()
    once = defence.defend(image, np.random.default_rng(3))
    assert once.dtype == np.uint8
    assert once.shape == image.shape
    assert (once == defence.defend(image, np.random.default_rng(3))).all()
    assert (image == _street()).all()
    # What is seen stays, colours above all.
    assert np.abs(once.astype(float) - image).mean() < 8


@pytest.mark.parametrize("quality", [20, 75, 100])
def test_jpeg_is_that_of_another_library(quality: int) -> None:
    file = io.BytesIO()
    Image.fromarray(_street()).save(file, "JPEG", quality=quality)
    theirs = np.asarray(Image.open(file)).astype(float)
    ours = make(Kind.DEFENCE, {"name": "jpeg", "quality": quality}).defend(_street(), _RANDOM)
    assert np.abs(ours - theirs).mean() < 1.0


def test_jpeg_takes_fine_noise_away_the_more_the_lower_its_quality() -> None:
    grey = np.full((64, 96, 3), 128, np.uint8)
    noisy = (grey + np.random.default_rng(4).choice([-4, 4], (64, 96, 1))).astype(np.uint8)
    left = [
        np.abs(
            make(Kind.DEFENCE, {"name": "jpeg", "quality": quality}).defend(noisy, _RANDOM) - 128.0
        )
        for quality in (95, 60, 10)
    ]
    assert left[0].mean() > left[1].mean() > left[2].mean()
    assert left[2].mean() < 1


@pytest.mark.parametrize("bits", range(1, 9))
def test_so_many_bits_are_so_many_levels_and_each_pixel_takes_the_nearest(bits: int) -> None:
    image = np.arange(256, dtype=np.uint8).reshape(16, 16, 1).repeat(3, axis=2)
    defence = make(Kind.DEFENCE, {"name": "bit_depth", "bits": bits})
    levels = np.unique(once := defence.defend(image, _RANDOM))
    assert len(levels) == 2**bits
    assert (levels[0], levels[-1]) == (0, 255)
    nearest = np.abs(image[..., None].astype(int) - levels.astype(int)).min(axis=-1)
    # Levels themselves are rounded to whole grey levels.
    assert (np.abs(once.astype(int) - image) <= nearest + 1).all()
    assert (defence.defend(once, _RANDOM) == once).all()


@pytest.mark.parametrize("width", [3, 5, 7])
def test_the_median_is_that_of_another_library(width: int) -> None:
    ours = make(Kind.DEFENCE, {"name": "median_filter", "width": width}).defend(_noise(), _RANDOM)
    theirs = ndimage.median_filter(_noise(), size=(width, width, 1), mode="nearest")
    assert (ours == theirs).all()


def test_noise_has_the_strength_that_is_asked_for_and_stays_within_grey_levels() -> None:
    grey = np.full((200, 300, 3), 128, np.uint8)
    noisy = make(Kind.DEFENCE, {"name": "gaussian_noise", "strength": 12}).defend(grey, _RANDOM)
    assert abs(noisy.astype(float).std() - 12) < 0.2
    assert abs(noisy.astype(float).mean() - 128) < 0.2
    loud = make(Kind.DEFENCE, {"name": "gaussian_noise", "strength": 255}).defend(grey, _RANDOM)
    assert (loud.min(), loud.max()) == (0, 255)


@pytest.mark.parametrize(
    "wrong",
    [
        {"name": "jpeg", "quality": 0},
        {"name": "jpeg", "quality": 50.5},
        {"name": "bit_depth", "bits": 9},
        {"name": "median_filter", "width": 4},
        {"name": "median_filter", "width": 33},
        {"name": "gaussian_noise", "strength": float("nan")},
        {"name": "gaussian_noise", "strength": -1},
        {"name": "jpg"},
    ],
)
def test_what_is_no_defence_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ConfigurationError):
        make(Kind.DEFENCE, wrong)
