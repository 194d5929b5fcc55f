"""Earlier editions of DSGN's presets, which old weights know by their cards."""

from __future__ import annotations

from avsec_gym.perception.detectors.dsgn.configuration import (
    FIRST_SMALL,
    DsgnConfiguration,
    without_pyramid,
)
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.recorded import is_recorded

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
    # Weights fit with and without the pyramid.
    features = {
        **card.configuration.get("features", {}),
        "pyramid": earlier.features.pyramid,
    }
    recorded = {**card.configuration, "features": features}
    return earlier if is_recorded(earlier, recorded) else preset
