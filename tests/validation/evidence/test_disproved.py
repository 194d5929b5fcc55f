"""Scan points whom the images of two cameras disprove, against a plain loop, and in a scene."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.behind_surfaces import LidarEye
from avsec_gym.validation.evidence.disparity_error import DisparityErrors, densest_share
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.disproved import MIN_EVIDENCE, NOISE, disproved_points

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


def test_a_bogus_return_is_disproved_and_light_is_none(
    wall_of: Callable[[int], SensorFrame],
) -> None:
    wall = wall_of(0)
    bogus = LidarSpoofing(reference=0, distance=6.0, bearing=0.0).attack(wall).frame
    lit = Facula(1, 300.0, (120.0, 60.0), saturation=0.9).attack(wall).frame
    clean, spoofed, dazzled = (
        DisparityErrors(DisparityMaps(frame, SYSTEM))[0, 2, 3] for frame in (wall, bogus, lit)
    )
    assert clean.densest < 0.002
    assert spoofed.densest > 0.02
    # E cannot tell which of the two is wrong, the images can.
    assert dazzled.error + dazzled.hole_share > 0.05
    assert dazzled.densest < 0.25 * spoofed.densest
    assert densest_share(np.zeros((10, 10), bool)) == 0.0


def test_a_bogus_return_behind_a_wall_is_disproved(wall_of: Callable[[int], SensorFrame]) -> None:
    """Whose points would be the nearest in few pixels: the wall's own stand before them."""
    wall = wall_of(0)
    behind = LidarSpoofing(reference=0, distance=20.0, bearing=0.0).attack(wall).frame
    clean, spoofed = (
        DisparityErrors(DisparityMaps(frame, SYSTEM))[0, 2, 3].densest for frame in (wall, behind)
    )
    assert spoofed > 5 * max(clean, 0.002)


def test_of_a_plain_surface_nothing_is_known() -> None:
    noise = np.random.default_rng(0).integers(0, 3, (2, 60, 120, 1), np.uint8)
    image, other = np.repeat(100 + noise, 3, axis=3)
    scan = DisparityMap(np.full((60, 120), 30, np.float32), 1.0)
    dense = DisparityMap(np.full((60, 120), 10, np.float32), 1.0)
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
