"""The preset moves on; weights that were trained for its first edition keep that."""

import json
from dataclasses import asdict, replace

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.stereo_rcnn.configuration import FIRST_SMALL, RESNET101, SMALL
from avsec_gym.perception.detectors.stereo_rcnn.decoding_rule import StereoRcnnDecodingRule
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.detectors.stereo_rcnn.editions import preset_of_weights
from avsec_gym.perception.weights.model_card import ModelCard

LATER = ("fit", "rule", "alignment")


def _card(configuration, without=()):
    fields = json.loads(json.dumps(asdict(configuration)))
    return ModelCard("stereo_rcnn", {k: v for k, v in fields.items() if k not in without})


def test_weights_of_the_first_edition_get_its_network():
    assert preset_of_weights("small", _card(FIRST_SMALL, LATER)) == FIRST_SMALL
    assert preset_of_weights("small", _card(FIRST_SMALL)) == FIRST_SMALL


def test_others_get_the_preset():
    for card in (None, _card(SMALL), _card(replace(SMALL, box_channels=512))):
        assert preset_of_weights("small", card) == SMALL
    assert preset_of_weights("resnet101", _card(RESNET101)) == RESNET101
    with pytest.raises(ConfigurationError, match="tiny"):
        preset_of_weights("tiny", None)


def test_the_weights_in_the_package_keep_working():
    detector = StereoRcnnDetector("small", weights="shipped")
    assert detector.configuration == preset_of_weights("small", detector.card)
    assert detector.rule == detector.configuration.rule
    assert detector.alignment == detector.configuration.alignment
    assert StereoRcnnDetector("small").configuration == SMALL


def test_a_share_of_the_fit_needs_the_fit():
    with pytest.raises(ConfigurationError, match="fit"):
        replace(FIRST_SMALL, rule=StereoRcnnDecodingRule(fit_share=0.5))
