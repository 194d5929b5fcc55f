"""Earlier editions of DSGN's presets, which old weights know by their cards."""

from __future__ import annotations

import json
from dataclasses import asdict

from avsec_gym.perception.detectors.dsgn.configuration import (
    FIRST_SMALL,
    DsgnConfiguration,
    without_pyramid,
)
from avsec_gym.perception.weights.model_card import ModelCard

_EARLIER = {
    "small": FIRST_SMALL,
    "small_without_pyramid": without_pyramid(FIRST_SMALL),
}


def preset_of_weights(name: str, card: ModelCard | None) -> DsgnConfiguration:
    """A preset, or its earlier edition where the weights were trained for that one.

    Args:
        name: Name of the preset.
        card: The card of the weights, which keeps their configuration; None: the preset as it is.

    Raises:
        ConfigurationError: No preset has the name.
    """
    preset = DsgnConfiguration.preset(name)
    if card is None or name not in _EARLIER:
        return preset
    earlier = _EARLIER[name]
    known = json.loads(json.dumps(asdict(earlier)))
    # Fields that came later are not in its card; weights fit with and without the pyramid.
    recorded = {field: value for field, value in card.configuration.items() if field in known}
    recorded["features"] = {**recorded.get("features", {}), "pyramid": earlier.features.pyramid}
    return earlier if recorded == {field: known[field] for field in recorded} else preset
