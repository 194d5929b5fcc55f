"""Two cameras' exposures, against all ratios one by one."""

from __future__ import annotations

from itertools import product

import cv2
import numpy as np
import pytest

from avsec_gym.frame import Image
from avsec_gym.validation.evidence.brightness import (
    FEWEST,
    Expected,
    brightness_inconsistency,
    compared_images,
    differing_pixels,
    equally_exposed,
    without_colours,
)


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
def test_the_exposure_is_that_which_most_pixels_agree_on_one_by_one(
    factors: tuple[float, float, float],
) -> None:
    expected = picture()
    image, known = exposed(expected, factors), np.zeros((120, 400), bool)
    known[:, 50:] = True
    found = equally_exposed(expected, image, known)
    telling = known & (expected.min(axis=2) >= 8) & (expected.max(axis=2) < 250)
    telling &= image.max(axis=2) < 250
    candidates = np.exp(np.linspace(-0.7, 0.7, 281))
    for colour, factor in enumerate(factors):
        was, seen = expected[telling][:, colour].astype(float), image[telling][:, colour]
        agreeing = [(np.abs(was * gain - seen) <= 4.0).sum() for gain in candidates]
        by_hand = candidates[np.argmax(agreeing)]
        assert by_hand == pytest.approx(factor, rel=0.03)
        levels = np.rint(np.minimum(expected[..., colour] * by_hand, 255))
        np.testing.assert_allclose(found.least[..., colour], levels, atol=2)
        over = expected[..., colour] >= 250
        assert (found.most[..., colour][over] == 255).all()
        np.testing.assert_array_equal(found.most[~over, colour], found.least[~over, colour])


def test_light_on_more_than_half_of_the_image_does_not_pass_for_exposure() -> None:
    expected, known = picture(), np.ones((120, 400), bool)
    lit = exposed(expected, (0.9, 0.9, 0.9))
    column = np.linspace(0, 120, 260)
    lit[:, :260] = np.clip(lit[:, :260] + column[:, None], 0, 255).astype(np.uint8)
    right = equally_exposed(expected, lit, known).least
    assert np.median(right / np.maximum(expected, 1)) == pytest.approx(0.9, abs=0.03)


def test_the_share_that_is_lit_is_counted() -> None:
    image = picture() // 2 + 40
    disparity = np.full((120, 400), 12.0, np.float32)
    other = np.roll(image, -12, axis=1)
    darker = exposed(other, (0.9, 0.9, 0.9))
    assert max(brightness_inconsistency(image, darker, disparity)) < 0.01
    lit = image.copy()
    lit[:, 100:200] += 80
    # A quarter of the columns, but for the twelve that the other camera does not see.
    share = pytest.approx(100 / 388, abs=0.03)
    found = brightness_inconsistency(lit, other, disparity)
    assert found.brighter == share
    assert found.darker < 0.01
    assert found.patches == share
    # The light in the other camera.
    lit = other.copy()
    lit[:, 100:200] += 80
    found = brightness_inconsistency(image, lit, disparity)
    assert found.darker == share
    assert found.brighter < 0.01
    assert found.patches == share
    # As many pixels, but here and there: a matcher's errors.
    specks = image.copy()
    specks[np.random.default_rng(0).random((120, 400)) < 0.25] += 80
    found = brightness_inconsistency(specks, other, disparity)
    assert found.brighter == pytest.approx(0.25, abs=0.03)
    assert found.patches < 0.001
    few = np.full_like(disparity, np.nan)
    few.ravel()[200 : 200 + FEWEST - 1] = 12.0
    assert brightness_inconsistency(image, other, few) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize("factor", [0.8, 1.25])
def test_a_sky_that_overflows_is_no_attack(factor: float) -> None:
    """One camera is exposed longer: what is white in both may be grey in neither."""
    radiance = np.asarray(picture(), float)
    radiance[:60] = np.linspace(225, 400, 60)[:, None, None]
    image = np.rint(np.minimum(radiance, 255)).astype(np.uint8)
    other = np.rint(np.minimum(radiance * factor, 255)).astype(np.uint8)
    disparity = np.zeros((120, 400), np.float32)
    assert max(brightness_inconsistency(image, other, disparity)) < 0.002
    # White where the scene is not is light.
    image[70:90, 100:200] = 255
    assert brightness_inconsistency(image, other, disparity).brighter > 0.03


def test_a_grey_camera_and_one_of_colours_see_alike() -> None:
    colours = picture()
    grey = np.repeat(np.rint(colours.mean(axis=2, keepdims=True)).astype(np.uint8), 3, axis=2)
    disparity = np.zeros((120, 400), np.float32)
    assert brightness_inconsistency(colours, grey, disparity) == (0.0, 0.0, 0.0)
    assert brightness_inconsistency(grey, colours, disparity) == (0.0, 0.0, 0.0)
    np.testing.assert_array_equal(without_colours(colours), grey)


def test_a_pixel_may_come_from_two_columns_and_one_row_beside() -> None:
    """A matcher's error is no light; farther away it is."""
    expected = np.full((40, 60, 3), 50, np.uint8)
    expected[20, 30] = 200
    known = np.ones((40, 60), bool)
    for row, column in product(range(-3, 4), range(-4, 5)):
        image = np.full_like(expected, 50)
        image[20 + row, 30 + column] = 200
        brighter, darker, judged = differing_pixels(image, Expected(expected, expected), known)
        differs = abs(row) > 1 or abs(column) > 2
        assert np.argwhere(brighter).tolist() == [[20 + row, 30 + column]] * differs
        assert not darker.any()
        assert judged.all()


def test_the_other_images_first_column_is_known() -> None:
    """A disparity as large as the column leads to column 0; a larger one out of the image."""
    image = np.full((20, 30, 3), 90, np.uint8)
    columns = np.broadcast_to(np.arange(30, dtype=np.float32), (20, 30))
    for more, share in ((0.0, 1.0), (0.5, 0.0)):
        _, _, known = compared_images(image, image, columns + np.float32(more))
        assert known.mean() == share


def test_nothing_to_go_by_leaves_the_exposure_as_it_is() -> None:
    image, dark = picture(), np.zeros((120, 400, 3), np.uint8)
    known = np.ones((120, 400), bool)
    np.testing.assert_array_equal(equally_exposed(dark, image, known).least, dark)
    known = np.zeros((120, 400), bool)
    np.testing.assert_array_equal(equally_exposed(image, image // 2, known).least, image)


def test_of_exposures_that_agree_with_as_many_pixels_the_middle_is_taken() -> None:
    """Of one level, all factors within four levels of it agree."""
    grey, known = np.full((120, 400, 3), 100, np.uint8), np.ones((120, 400), bool)
    found = equally_exposed(grey, np.full_like(grey, 120), known)
    np.testing.assert_allclose(found.least, 120, atol=1)
    np.testing.assert_allclose(equally_exposed(grey, grey, known).least, 100, atol=1)


def test_what_overflows_has_no_say_in_the_exposure() -> None:
    """A white sky of 255 is of any brightness; most of the image is one here."""
    expected, known = np.full((120, 400, 3), 100, np.uint8), np.ones((120, 400), bool)
    image = np.full_like(expected, 80)
    expected[:80], image[:80] = 255, 128
    np.testing.assert_allclose(equally_exposed(expected, image, known).least[80:], 80, atol=1)
    brighter = np.full_like(expected, 100)
    brighter[:80], expected[:80] = 255, 200
    found = equally_exposed(expected, brighter, known)
    np.testing.assert_allclose(found.least[80:], 100, atol=1)
