"""Earlier editions of DSGN's presets, which old weights know by their cards."""

from __future__ import annotations

from avsec_gym.errors import ConfigurationError
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
_TRAINED = ("small", "medium")
"""Presets that weights were trained for here."""


def preset_of_weights(name: str, card: ModelCard | None) -> DsgnConfiguration:
    """A preset, or its earlier edition where the weights were trained for that one.

    Args:
        name: Name of the preset.
        card: The card of the weights, which keeps their configuration; None: the preset as it is.

    Raises:
        ConfigurationError: No preset has the name, or the weights are those of another preset: they
            may fit, and answer wrongly.
    """
    preset = DsgnConfiguration.preset(name)
    if card is None or _is_network(preset, card):
        return preset
    if name in _EARLIER and _is_network(_EARLIER[name], card):
        return _EARLIER[name]
    others = [other for other in _TRAINED if _is_network(DsgnConfiguration.preset(other), card)]
    if others:
        raise ConfigurationError(
            f"these weights of DSGN are those of the preset {others[0]!r}, not of {name!r}: name"
            f' it, as in {{"name": "dsgn", "configuration": "{others[0]}", "weights": ...}}'
        )
    return preset


def preset_name(card: ModelCard) -> str:
    """The preset that weights were trained for; ``small`` where none is known to be theirs."""
    fitting = (name for name in _TRAINED if _is_network(DsgnConfiguration.preset(name), card))
    return next(fitting, "small")


def _is_network(configuration: DsgnConfiguration, card: ModelCard) -> bool:
    """Whether weights were trained for this network, however its boxes are chosen.

    Weights fit with and without the pyramid.
    """
    features = {
        **card.configuration.get("features", {}),
        "pyramid": configuration.features.pyramid,
    }
    recorded = {**card.configuration, "features": features}
    recorded.pop("rule", None)
    return is_recorded(configuration, recorded)
