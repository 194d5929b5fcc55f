"""Two cameras' exposures, against all ratios one by one."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from avsec_gym.frame import Image
from avsec_gym.validation.brightness import FEWEST, brightness_inconsistency, equally_exposed


def picture(seed: int = 0) -> Image:
    """Soft patches of all colours, and some noise."""
    random = np.random.default_rng(seed)
    coarse = random.integers(0, 256, (12, 40, 3), np.uint8)
    soft = np.asarray(cv2.resize(coarse, (400, 120), interpolation=cv2.INTER_CUBIC), float)
    return np.rint(np.clip(soft + random.normal(0, 5, soft.shape), 0, 255)).astype(np.uint8)


def exposed(image: Image, factors: tuple[float, ...]) -> Image:
    noise = np.random.default_rng(1).normal(0, 1.5, image.shape)
    return np.rint(np.clip(image * np.array(factors) + noise, 0, 255)).astype(np.uint8)


@pytest.mark.parametrize("factors", [(1.0, 1.0, 1.0), (0.8, 0.9, 1.2), (1.6, 1.6, 1.5)])
def test_the_exposure_is_that_of_all_ratios_one_by_one(factors: tuple[float, ...]) -> None:
    expected = picture()
    image, known = exposed(expected, factors), np.zeros((120, 400), bool)
    known[:, 50:] = True
    found = equally_exposed(expected, image, known)
    telling = known & (expected.min(axis=2) >= 8) & (image.max(axis=2) < 250)
    for colour, factor in enumerate(factors):
        ratios = np.log(np.maximum(image[telling], 1) / expected[telling])[:, colour]
        counts, edges = np.histogram(ratios, 141, (-0.7, 0.7))
        best = np.convolve(counts, np.ones(5), "same").argmax()
        by_hand = np.exp((edges[best] + edges[best + 1]) / 2)
        assert by_hand == pytest.approx(factor, rel=0.03)
        np.testing.assert_array_equal(
            found[..., colour], np.rint(np.minimum(expected[..., colour] * by_hand, 255))
        )


def test_light_on_more_than_half_of_the_image_does_not_pass_for_exposure() -> None:
    expected, known = picture(), np.ones((120, 400), bool)
    lit = exposed(expected, (0.9, 0.9, 0.9))
    column = np.linspace(0, 120, 260)
    lit[:, :260] = np.clip(lit[:, :260] + column[:, None], 0, 255).astype(np.uint8)
    right = equally_exposed(expected, lit, known)
    assert np.median(right / np.maximum(expected, 1)) == pytest.approx(0.9, abs=0.03)


def test_the_share_that_is_lit_is_counted() -> None:
    image = picture() // 2 + 40
    disparity = np.full((120, 400), 12.0, np.float32)
    other = np.roll(image, -12, axis=1)
    assert brightness_inconsistency(image, exposed(other, (0.9, 0.9, 0.9)), disparity) < 0.01
    lit = image.copy()
    lit[:, 100:200] += 80
    found = brightness_inconsistency(lit, other, disparity)
    # A quarter of the columns, but for the twelve that the other camera does not see.
    assert found == pytest.approx(100 / 388, abs=0.03)
    few = np.full_like(disparity, np.nan)
    few.ravel()[200 : 200 + FEWEST - 1] = 12.0
    assert brightness_inconsistency(image, other, few) == 1.0


def test_nothing_to_go_by_leaves_the_exposure_as_it_is() -> None:
    image, dark = picture(), np.zeros((120, 400, 3), np.uint8)
    np.testing.assert_array_equal(equally_exposed(dark, image, np.ones((120, 400), bool)), dark)
    known = np.zeros((120, 400), bool)
    np.testing.assert_array_equal(equally_exposed(image, image // 2, known), image)
