"""Benign changes, each against OpenCV, NumPy or arithmetic."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.rig import kitti_rig
from avsec_gym.validation.benign_changes import (
    BENIGN_CHANGES,
    Blur,
    Gain,
    Jpeg,
    Miscalibration,
    RainDrops,
    with_changed_camera,
)


@pytest.fixture
def image() -> Image:
    return np.random.default_rng(0).integers(0, 256, (60, 90, 3), np.uint8)


def changed(change: object, image: Image, seed: int = 0) -> Image:
    found = change.changed(image, np.random.default_rng(seed))  # type: ignore[attr-defined]
    assert found.dtype == np.uint8
    assert found.shape == image.shape
    return np.asarray(found)


def test_a_gain_multiplies_and_cuts_off(image: Image) -> None:
    found = changed(Gain(1.5), image)
    np.testing.assert_array_equal(found, np.minimum(np.rint(image * 1.5), 255))
    np.testing.assert_array_equal(changed(Gain(1.0), image), image)


def test_jpeg_is_that_of_opencv(image: Image) -> None:
    _, coded = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 30])
    expected = cv2.imdecode(coded, cv2.IMREAD_COLOR)[..., ::-1]
    np.testing.assert_array_equal(changed(Jpeg(30), image), expected)


def test_a_blur_keeps_the_mean_and_is_as_wide_as_it_is_meant_to_be() -> None:
    dot = np.zeros((41, 41, 3), np.uint8)
    dot[20, 20] = 255
    for sigma in (1.0, 2.0):
        found = changed(Blur(sigma), dot)[..., 0].astype(float)
        share = found[20] / found[20].sum()
        spread = np.sqrt((share * (np.arange(41) - 20) ** 2).sum())
        assert spread == pytest.approx(sigma, rel=0.2)


@pytest.mark.parametrize(("rows", "columns"), [(1, 0), (0, 1), (-2, 3)])
def test_a_moved_camera_moves_its_image(image: Image, rows: int, columns: int) -> None:
    found = changed(Miscalibration(rows, columns), image)
    inner = np.roll(image, (rows, columns), (0, 1))[4:-4, 4:-4]
    np.testing.assert_array_equal(found[4:-4, 4:-4], inner)


def test_drops_blur_what_they_cover_and_nothing_else() -> None:
    image = np.random.default_rng(0).integers(0, 256, (375, 1242, 3), np.uint8)
    found = changed(RainDrops(3), image)
    differs = (found != image).any(axis=2)
    # Three discs of at most 24 pixels, and at least 8 where the image holds the whole of one.
    assert 0 < differs.sum() <= 3 * np.pi * 25**2
    components, _ = cv2.connectedComponents(cv2.dilate(differs.astype(np.uint8), np.ones((5, 5))))
    assert components - 1 <= 3
    inside = cv2.erode(differs.astype(np.uint8), np.ones((9, 9))) > 0
    assert found[inside].std() < 0.5 * image[inside].std()
    np.testing.assert_array_equal(changed(RainDrops(0), image), image)
    assert (changed(RainDrops(3), image, seed=1) != found).any()
    np.testing.assert_array_equal(changed(RainDrops(3), image), found)


def test_one_camera_alone_changes(image: Image) -> None:
    frame = SensorFrame("0", kitti_rig().calibration, {2: image, 3: image.copy()})
    for change in BENIGN_CHANGES.values():
        found = with_changed_camera(frame, 3, change, (1, 2))
        assert (found.image(3) != image).any()
        np.testing.assert_array_equal(found.image(2), image)


def test_what_cannot_be_is_refused() -> None:
    for make in (
        lambda: Gain(0.0), lambda: Blur(-1.0), lambda: Jpeg(0), lambda: RainDrops(-1),
        lambda: Miscalibration(float("nan")),
    ):  # fmt: skip
        with pytest.raises(ConfigurationError):
            make()
