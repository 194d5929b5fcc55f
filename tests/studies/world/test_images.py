"""Numbers of images."""

from __future__ import annotations

import numpy as np
import pytest

from studies.world.images import QUANTITIES, ImageNumbers, statistics, summary


def plain(level: float, noise: float = 0.0) -> np.ndarray:
    grey = level + noise * np.random.default_rng(0).standard_normal((240, 480, 1))
    return np.repeat(np.round(np.clip(grey, 0, 255)), 3, axis=2).astype(np.uint8)


def test_noise_is_measured_in_grey_values() -> None:
    assert statistics(plain(50, 3.0))["noise_dark"] == pytest.approx(3.0, rel=0.2)
    assert statistics(plain(150, 6.0))["noise_bright"] == pytest.approx(6.0, rel=0.2)
    assert np.isnan(statistics(plain(150))["noise_dark"])


def test_brightness_and_colour() -> None:
    image = plain(100)
    image[..., 0] = 50
    result = statistics(image)
    assert set(result) == set(QUANTITIES)
    assert result["red_to_green"] == pytest.approx(0.5)
    assert result["blue_to_green"] == pytest.approx(1.0)
    assert result["detail_1"] == 0.0
    assert statistics(plain(255))["saturated"] == 100.0
    assert statistics(plain(10))["dark"] == 100.0


def test_what_is_not_known_is_left_out_of_means() -> None:
    row = ImageNumbers(dict.fromkeys(QUANTITIES, 1.0))
    unknown = ImageNumbers({**row.values, "noise_dark": None})
    result = summary([row, unknown], {}).quantities["noise_dark"]
    assert result.ours == (1.0, 0.0)
    assert result.real is None
