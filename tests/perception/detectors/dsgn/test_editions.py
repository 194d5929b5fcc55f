"""Presets move on; weights that were trained for an earlier edition keep theirs."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.dsgn.configuration import (
    FIRST_SMALL,
    DsgnConfiguration,
    without_pyramid,
)
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.detectors.dsgn.editions import preset_name, preset_of_weights
from avsec_gym.perception.weights.model_card import ModelCard


def _card(configuration: DsgnConfiguration, *without: str) -> ModelCard:
    fields = json.loads(json.dumps(asdict(configuration)))
    return ModelCard("dsgn", {k: v for k, v in fields.items() if k not in without})


LATER = ("half_turns", "fit", "depth_loss", "object_pixels", "rule")


def test_weights_of_the_first_edition_get_its_network() -> None:
    old = _card(FIRST_SMALL, *LATER)
    assert preset_of_weights("small", old) == FIRST_SMALL
    bare = preset_of_weights("small_without_pyramid", old)
    assert bare == without_pyramid(FIRST_SMALL)
    assert preset_of_weights("small", _card(bare, *LATER)) == FIRST_SMALL


@pytest.mark.parametrize("name", ["small", "medium", "12g"])
def test_others_get_the_preset(name: str) -> None:
    preset = DsgnConfiguration.preset(name)
    assert preset_of_weights(name, None) == preset
    assert preset_of_weights(name, _card(preset)) == preset
    wider = replace(preset, view_channels=2 * preset.view_channels)
    assert preset_of_weights(name, _card(wider)) == preset


@pytest.mark.parametrize("name", ["small", "medium"])
def test_the_weights_in_the_package_are_those_of_their_preset(name: str) -> None:
    detector = DsgnDetector(name, weights="shipped")
    assert detector.card is not None
    assert detector.configuration == DsgnConfiguration.preset(name)
    assert detector.rule == detector.configuration.rule
    assert preset_name(detector.card) == name


def test_weights_of_another_preset_are_refused_though_they_fit() -> None:
    card = _card(DsgnConfiguration.preset("medium"), "rule")
    with pytest.raises(ConfigurationError, match="'medium', not of 'small'"):
        preset_of_weights("small", card)
    assert preset_of_weights("medium", card) == DsgnConfiguration.preset("medium")
    # Features of PSMNet and the like are of no preset at all.
    assert preset_name(ModelCard("dsgn", {"input_size": [1, 1]})) == "small"
