"""Scan points whom the images of two cameras disprove, against a plain loop, and in a scene."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.behind_surfaces import LidarEye
from avsec_gym.validation.evidence.disproved import (
    MIN_EVIDENCE,
    NOISE,
    _census,
    _unlike,
    disproved_points,
)

SYSTEM = SensorSystem((LIDAR, 2, 1, 0))
NOWHERE = LidarEye(1.0, 0.0, 0.0, np.array([0.0, 0.0, 1e6]), 1.0)
"""To whom nothing is behind anything."""


def unlike(left: np.ndarray, right: np.ndarray, v: int, u: int, disparity: float) -> float:
    """The share of the window, cut to both images, that is brighter or darker in one."""

    def census(level: int, middle: int) -> int:
        return 0 if abs(level - middle) <= NOISE else int(np.sign(level - middle))

    shares = []
    for column in (round(u - disparity) + shift for shift in (-1, 0, 1)):
        if not 0 <= column < right.shape[1]:
            continue
        differing = [
            census(left[v + i, u + j], left[v, u])
            != census(right[v + i, column + j], right[v, column])
            for i in range(-5, 6)
            for j in range(-6, 7)
            if 0 <= v + i < left.shape[0]
            and 0 <= u + j < left.shape[1]
            and 0 <= column + j < left.shape[1]
        ]
        if len(differing) >= 11 * 13 / 2:
            shares.append(float(np.mean(differing)))
    return min(shares, default=np.nan)


def test_pixels_are_those_of_a_plain_loop() -> None:
    random = np.random.default_rng(0)
    grey = cv2.GaussianBlur(random.integers(0, 256, (40, 90), np.uint8), (0, 0), 1.5)
    image = np.repeat(grey[..., None], 3, axis=2)
    other = np.roll(image, -10, axis=1)
    dense = np.full((40, 90), 10.0, np.float32)
    dense[:, 60:] = 3.0  # A matcher that is wrong there.
    scan = np.full_like(dense, np.nan)
    scan[::3, ::2] = random.choice([3.0, 10.0, 12.0, 20.0, 31.4], scan[::3, ::2].shape)
    scan[::3, 64:] = 10.0
    found = disproved_points(
        DisparityMap(2 * scan, 200.0), DisparityMap(dense, 100.0), image, other, NOWHERE
    )
    left, right = (cv2.blur(pixels[..., 0], (3, 3)).astype(int) for pixels in (image, other))
    expected = np.zeros(scan.shape, bool)
    for v, u in np.argwhere(np.isfinite(scan)):
        nearer = scan[v, u] - dense[v, u] > 3
        evidence = unlike(left, right, v, u, scan[v, u]) - unlike(left, right, v, u, dense[v, u])
        expected[v, u] = nearer and evidence > MIN_EVIDENCE
    np.testing.assert_array_equal(found, expected)
    assert found[:, 20:55].any()
    # Where the matcher is wrong, the images are with the scan.
    assert not found[6:-6, 70:-8].any()
    nothing = DisparityMap(np.full_like(dense, np.nan), 1.0)
    assert not disproved_points(nothing, DisparityMap(dense, 1.0), image, other, NOWHERE).any()


@pytest.mark.parametrize("shape", [(9, 21), (13, 16), (24, 19)])
def test_pixels_around_are_compared_as_far_as_both_images_have_them(
    shape: tuple[int, int],
) -> None:
    random = np.random.default_rng(shape[0])
    # Few grey levels, so that many differ by just the noise.
    left, right = random.integers(60, 70, (2, *shape)).astype(np.uint8)
    right[:, :-4] = np.where(random.random(shape) < 0.7, left, right)[:, 4:]
    known = set()
    for v in range(shape[0]):
        for u in range(v % 3, shape[1], 3):
            for disparity in (4.0, float(random.uniform(-3.0, 12.0))):
                found = _unlike(left, right, v, u, disparity)
                expected = unlike(left.astype(int), right.astype(int), v, u, disparity)
                assert found == pytest.approx(expected, nan_ok=True)
                known.add(bool(np.isnan(expected)))
    assert known == {True, False}


def test_beyond_the_border_of_the_other_image_nothing_is_read() -> None:
    """As plain Python has it, which minds: compiled, an index may leave an image unseen."""
    plain = getattr(_unlike, "py_func", _unlike)
    image = np.full((11, 13), 100, np.uint8)
    for disparity in (-1.0, -0.4, 0.0, 0.4, 1.0):
        # Where a column to the right of the last one is asked for, and one left of the first.
        assert plain(image, image, 5, 12, disparity) == plain(image, image, 5, 0, disparity) == 0.0
    for disparity in (-20.0, 20.0):
        assert np.isnan([plain(image, image, 5, u, disparity) for u in (0, 12)]).all()


@pytest.mark.parametrize(("level", "middle", "step"), [
    (13, 10, 0), (14, 10, 1), (7, 10, 0), (6, 10, -1), (10, 10, 0), (0, 3, 0), (0, 4, -1),
    (200, 3, 1), (3, 200, -1),
])  # fmt: skip
def test_a_pixel_is_as_bright_up_to_the_noise(level: int, middle: int, step: int) -> None:
    assert _census(np.uint8(level), np.uint8(middle)) == step


def test_of_a_plain_surface_nothing_is_known() -> None:
    noise = np.random.default_rng(0).integers(0, 3, (2, 22, 60, 1), np.uint8)
    image, other = np.repeat(100 + noise, 3, axis=3)
    scan = DisparityMap(np.full((22, 60), 30, np.float32), 1.0)
    dense = DisparityMap(np.full((22, 60), 10, np.float32), 1.0)
    assert not disproved_points(scan, dense, image, other, NOWHERE).any()


def test_maps_of_two_sizes_are_refused() -> None:
    image = np.zeros((4, 4, 3), np.uint8)
    with pytest.raises(ConfigurationError, match="one shape"):
        disproved_points(
            DisparityMap(np.zeros((4, 4), np.float32), 1.0),
            DisparityMap(np.zeros((4, 5), np.float32), 1.0),
            image,
            image,
            NOWHERE,
        )
