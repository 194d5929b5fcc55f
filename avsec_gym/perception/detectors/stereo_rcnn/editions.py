"""The earlier edition of Stereo R-CNN's preset `small`, which old weights know by their cards."""

from __future__ import annotations

from avsec_gym.perception.detectors.stereo_rcnn.configuration import (
    FIRST_SMALL,
    StereoRcnnConfiguration,
)
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.recorded import is_recorded


def preset_of_weights(name: str, card: ModelCard | None) -> StereoRcnnConfiguration:
    """A preset, or its earlier edition where the weights were trained for that one.

    Args:
        name: Name of the preset.
        card: The card of the weights, which keeps their configuration; None: the preset as it is.

    Raises:
        ConfigurationError: No preset has the name.
    """
    preset = StereoRcnnConfiguration.preset(name)
    is_first = (
        card is not None
        and name == FIRST_SMALL.name
        and is_recorded(FIRST_SMALL, card.configuration)
    )
    return FIRST_SMALL if is_first else preset
