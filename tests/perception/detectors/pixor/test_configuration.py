"""Numbers of the original, and numbers that do not fit."""

from __future__ import annotations

from dataclasses import replace

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.pixor.configuration import BirdEyeRegion, PixorConfiguration


def test_the_default_region_is_that_of_the_original() -> None:
    default = PixorConfiguration.preset("default")
    assert default.region.shape == (36, 800, 700)
    assert default.output_shape == (200, 175)
    assert default.output_cell == pytest.approx(0.4)
    assert default.corners()[0, 0].tolist() == [0, -40]
    assert default.corners()[199, 174] == pytest.approx([69.6, 39.6])


def test_the_small_one_tells_as_finely() -> None:
    small = PixorConfiguration.preset("small")
    assert small.output_cell == pytest.approx(0.4)
    assert small.output_shape == (100, 112)


def test_what_does_not_fit_is_refused() -> None:
    small = PixorConfiguration.preset("small")
    with pytest.raises(ConfigurationError, match="whole steps"):
        BirdEyeRegion(cell=0.3)
    with pytest.raises(ConfigurationError, match="whole steps"):
        BirdEyeRegion(left=(3.0, -3.0))
    with pytest.raises(ConfigurationError, match="not a multiple"):
        replace(small, region=replace(small.region, left=(-0.2, 0.4)))
    with pytest.raises(ConfigurationError, match="stride is 1 or 2"):
        replace(small, strides=(2, 3, 1, 1))
    with pytest.raises(ConfigurationError, match="default, small"):
        PixorConfiguration.preset("large")
