"""Configurations by name: the preset, or an error that names those there are."""

from __future__ import annotations

from dataclasses import replace

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration
from avsec_gym.perception.presets import chosen_configuration, preset_named


def test_an_unknown_name_is_refused_with_those_there_are() -> None:
    assert preset_named("PIXOR", "b", {"c": 1, "b": 2}) == 2
    with pytest.raises(ConfigurationError, match="no PIXOR is called 'd'; there are b, c"):
        preset_named("PIXOR", "d", {"c": 1, "b": 2})


def test_a_preset_keeps_its_name_and_a_variation_counts_as_small() -> None:
    """Shipped weights are those of the preset; a live configuration is taken as it is."""
    default = PixorConfiguration.preset("default")
    assert chosen_configuration(PixorConfiguration, "default") == (default, "default")
    narrow = replace(default, stem=8)
    assert chosen_configuration(PixorConfiguration, narrow) == (narrow, "small")
